"""The verbs of kite-ground, in the order of its help."""

from kite_analysis.console.verbs import Verb

_PARAMETERS, _FILES, _LOAD = (
    "ground.cli.parameters", "ground.cli.parameter_files", "ground.cli.parameter_load")
_VEHICLE, _LOGS = "ground.cli.vehicle", "ground.cli.logs"

_OF_PARAM = (
    Verb("show", "list parameters; * marks those not at their default",
         f"{_PARAMETERS}:add_show_options", f"{_PARAMETERS}:show_parameters"),
    Verb("get", "show one parameter and what it means",
         f"{_PARAMETERS}:add_get_options", f"{_PARAMETERS}:get_parameter"),
    Verb("set", "set one parameter, and wait until the kite acknowledges it",
         f"{_PARAMETERS}:add_set_options", f"{_PARAMETERS}:set_parameter"),
    Verb("save", "write all parameters to a file",
         f"{_FILES}:add_save_options", f"{_FILES}:save_parameters"),
    Verb("savechanged", "write the parameters that are not at their default to a file",
         f"{_FILES}:add_save_changed_options", f"{_FILES}:save_changed"),
    Verb("diff", "show parameters that differ from a file, the defaults or the snapshot",
         f"{_FILES}:add_difference_options", f"{_FILES}:show_difference"),
    Verb("load", "set the parameters that differ from a file (MAVProxy, Mission Planner, QGroundControl)",
         f"{_LOAD}:add_load_options", f"{_LOAD}:load_file"),
    Verb("revert", "restore the parameters as they were when this flight began",
         f"{_LOAD}:add_revert_options", f"{_LOAD}:revert"),
    Verb("snapshot", "take the present values as the snapshot that `param revert` restores",
         f"{_LOAD}:add_snapshot_options", f"{_LOAD}:take_snapshot"),
    Verb("watch", "print each parameter change, from any ground station",
         f"{_PARAMETERS}:add_watch_options", f"{_PARAMETERS}:watch_parameters"),
)
_OF_LOG = (
    Verb("export", "write a recorded flight in another format",
         f"{_LOGS}:add_export_options", f"{_LOGS}:export"),
)

VERBS = (
    Verb("monitor", "watch the kite live: a table in a terminal, one line a second in a pipe",
         f"{_VEHICLE}:add_monitor_options", f"{_VEHICLE}:show_monitor"),
    Verb("mode", "show the mode, or change it and wait until the kite reports it",
         f"{_VEHICLE}:add_mode_options", f"{_VEHICLE}:change_mode"),
    Verb("arm", "arm, and wait until the kite is armed",
         f"{_VEHICLE}:add_arm_options", f"{_VEHICLE}:arm"),
    Verb("disarm", "disarm, and wait until the kite is disarmed",
         f"{_VEHICLE}:add_disarm_options", f"{_VEHICLE}:disarm"),
    Verb("param", "show, set, save and load the kite's parameters",
         "ground.cli.options:add_group_link_options", verbs=_OF_PARAM),
    Verb("tune", "measure the loop delay in flight, show what INNER_P it allows under the present control law, and set "
         "it or try a step", "ground.cli.tune:add_tune_options", "ground.cli.tune:tune"),
    Verb("record", "record everything received to a .tlog until Ctrl-C; reads all parameters first, so that the log "
         "has them", "ground.cli.record:add_record_options", "ground.cli.record:record"),
    Verb("replay", "replay a recorded flight to a ground station, as if the kite were flying",
         f"{_LOGS}:add_replay_options", f"{_LOGS}:replay"),
    Verb("log", "convert a recorded flight", verbs=_OF_LOG),
    Verb("plot", "plot a recorded flight: the sky, turning angle, steering, links",
         f"{_LOGS}:add_plot_options", f"{_LOGS}:plot"),
    Verb("completion", "print a shell script that completes verbs, options and parameter names",
         "ground.cli.completion:add_completion_options", "ground.cli.completion:print_completion"),
)
