"""The verbs of kite-sitl, in the order of its help."""

from kite_analysis.console.verbs import Verb

_OPTIONS, _ACTIONS, _LISTINGS = "sim_bridge.cli.options", "sim_bridge.cli.actions", "sim_bridge.cli.listings"

VERBS = (
    Verb("list", "list the scenarios that come with kitepilot",
         f"{_OPTIONS}.listings:add_json_option", f"{_LISTINGS}:list_scenarios"),
    Verb("keys", "list every key for --set and scenario files",
         f"{_OPTIONS}.listings:add_json_option", f"{_LISTINGS}:list_keys"),
    Verb("run", "fly a scenario", f"{_OPTIONS}.flight:add_run_options", f"{_ACTIONS}:run"),
    Verb("hil", "let a real board fly the simulated kite", f"{_OPTIONS}.flight:add_hil_options", f"{_ACTIONS}:hil"),
    Verb("rerun", "fly a logged run again and compare it to the bit",
         f"{_OPTIONS}.flight:add_rerun_options", "sim_bridge.cli.rerun:rerun"),
    Verb("paper", "reproduce the paper's figures, and a table of their numbers",
         f"{_OPTIONS}.studies:add_paper_options", f"{_ACTIONS}:paper"),
    Verb("shadow", "run the firmware as the shadow of a real flight",
         f"{_OPTIONS}.studies:add_shadow_options", f"{_ACTIONS}:shadow"),
    Verb("bench", "measure the speed of the loop on this machine",
         f"{_OPTIONS}.studies:add_bench_options", "sim_bridge.cli.bench:bench"),
    Verb("sweep", "fly a scenario many times, over a grid or a random sample",
         f"{_OPTIONS}.sweep:add_sweep_options", "sim_bridge.cli.sweep:sweep_command"),
    Verb("validate",
         "compare the turning-rate law and the plants with real flights and each other, in a page of tables",
         f"{_OPTIONS}.studies:add_validate_options", "sim_bridge.cli.validate:validate_command"),
    Verb("design", "compute gains for a delay: limits, best pair, margins",
         f"{_OPTIONS}.design:add_design_options", "sim_bridge.cli.design:design_gains"),
    Verb("identify", "identify K, gravity and the steering actuator from a flight",
         f"{_OPTIONS}.identify:add_identify_options", "sim_bridge.cli.identify:identify"),
    Verb("board-image", "write a board's files into a folder",
         f"{_OPTIONS}.boards:add_image_options", "sim_bridge.cli.boards:board_image"),
    Verb("flash", "install the firmware on a board",
         f"{_OPTIONS}.boards:add_flash_options", "sim_bridge.cli.boards:flash_board"),
)
