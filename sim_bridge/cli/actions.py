"""The verbs of `kite-sitl` that fly, or measure what flies; every function returns the exit code."""

import json
import math
from argparse import Namespace
from pathlib import Path
from typing import Any

from kite_analysis.plots import plot_flight
from kite_analysis.verdicts import UNSTABLE_TURNING_ANGLE
from protocol.modes import mode_name
from sim_bridge.cli.notes import notice, say
from sim_bridge.cli.plot_option import plot_path, save_plot
from sim_bridge.cli.progress import FlightProgress
from sim_bridge.cli.scenario_options import scenario_of
from sim_bridge.errors import ScenarioError
from sim_bridge.flight.flight import Flight
from sim_bridge.flight.judgement import MODE_UNKNOWN
from sim_bridge.runs.hardware_in_the_loop import fly_board
from sim_bridge.runs.run import RunOptions, RunResult, run_scenario
from sim_bridge.scenario.scenario import Scenario
from sim_bridge.studies.paper import make_paper
from sim_bridge.studies.shadow_flight import fly_shadow, plot_shadow


def run(options: Namespace) -> int:
    """`kite-sitl run`."""
    scenario = scenario_of(options, notice)
    options.runtime = options.runtime or ("cpython" if options.ground else "inproc")
    plot = _plot_path(options, scenario)
    with _progress(options, scenario) as progress:
        result = run_scenario(scenario, _run_options(options, scenario, progress), notice=notice)
    report(result, options.json)
    _keep(result, options, plot)
    return 0


def hil(options: Namespace) -> int:
    """`kite-sitl hil`."""
    scenario = scenario_of(options, notice)
    options.runtime, options.speed, options.interpreter = "hil", 1.0, None
    plot = _plot_path(options, scenario)
    notice("the scenario's parameters overwrite the board's; `kite-ground param save` keeps a copy of those")
    with _progress(options, scenario) as progress:
        result, board = fly_board(scenario, options.link, _run_options(options, scenario, progress), notice)
    if options.json:
        print(json.dumps(result.numbers | board))
    else:
        report(result, False)
        if board["board_delay_s"] is not None:
            print(f"the board takes {1000 * board['board_delay_s']:.1f} ms from sample to steering, up to "
                  f"{1000 * board['board_jitter_s']:.1f} ms more at times; {1000 * board['delay_emulated_s']:.1f} ms "
                  f"were emulated; {1000 * board['delay_flown_s']:.1f} ms were flown, "
                  f"{1000 * board['delay_asked_s']:.0f} requested")
    _keep(result, options, plot)
    return 0


def _plot_path(options: Namespace, scenario: Scenario) -> Path | None:
    """Where --plot draws the flight; what is wrong with that is said now, and not after the flight."""
    log = Path(options.log) if options.log else None
    name = Path(f"{scenario.name}.png")
    return plot_path(options, log / name if log else name)


def _progress(options: Namespace, scenario: Scenario) -> FlightProgress:
    seconds = None if options.forever else scenario.run.duration_s
    return FlightProgress(seconds, not (options.json or options.status))


def _run_options(options: Namespace, scenario: Scenario, progress: FlightProgress) -> RunOptions:
    if options.ground and not options.json:
        ground = scenario.ground
        print(f"ground stations: the kite sends to udp {ground.send_to} and listens on {ground.listen}", flush=True)
    return RunOptions(
        options.runtime, options.speed, options.ground, options.forever, Path(options.log) if options.log else None,
        _print_status if options.status else progress, log_limit_mb=options.log_limit, interpreter=options.interpreter)


def _keep(result: RunResult, options: Namespace, plot: Path | None) -> None:
    """Say where the log is, and draw the plot."""
    log = Path(options.log) if options.log else None
    if log and not options.json:
        again = "" if result.real_time else f"   (again: kite-sitl rerun {log})"
        upto = f", up to {result.log_until_s:.1f} s" if result.log_until_s is not None else ""
        print(f"log: {log}{upto}{again}")
    if plot and len(result.flight.truth):
        error_rad = result.numbers["cross_track_rms_rad"]
        error = "" if error_rad is None else f", cross-track error {math.degrees(error_rad):.2g} deg RMS"
        title = f"{result.numbers['scenario']}: {result.numbers['verdict']}{error}"
        save_plot(plot_flight(result.flight.track(), result.flight.eight, title), plot)
        notice(f"plot: {plot}")


def paper(options: Namespace) -> int:
    """`kite-sitl paper`."""
    folder = Path(options.out)
    try:
        rows = make_paper(folder, options.plant, options.force, (lambda text: None) if options.json else print)
    except OSError as error:
        raise ScenarioError(f"--out {folder}: {error.strerror}") from error
    if options.json:
        print(json.dumps(rows))
        return 0
    print(f"\n{'scenario':34} {'verdict':10} {'cross-track rms':>16} {'turning angle rms':>18}")
    for row in rows:
        print(f"{row['scenario']:34} {row['verdict']:10} {row['cross_track_rms_rad']:12.4f} rad "
              f"{row['turning_angle_rms_rad']:14.3f} rad")
    print(f"seven figures and numbers.csv in {folder}")
    return 0


def shadow(options: Namespace) -> int:
    """`kite-sitl shadow`."""
    path = Path(options.file)
    plot = plot_path(options, Path(f"{path.name.split('.')[0]}-shadow.png"))
    result = fly_shadow(path, options.runtime, notice, Path(options.columns) if options.columns else None,
                        options.interpreter)
    numbers: dict[str, Any] = dict(result.numbers)
    if plot:
        save_plot(plot_shadow(result, path.name), plot)
        numbers["plot"] = str(plot)
    if options.json:
        print(json.dumps(numbers))
        return 0
    eight = result.eight
    print(f"{path.name}: {numbers['reel_out_s']:.0f} s of reel-out")
    print("turning angle from positions compared with the recorded course: "
          f"{numbers['turning_angle_rms_deg']:.2f} deg RMS, "
          f"bias {numbers['turning_angle_bias_deg']:+.2f} deg")
    print(f"fitted eight: azimuth {math.degrees(eight.azimuth):+.1f} +- {math.degrees(eight.half_width):.1f} deg, "
          f"elevation {math.degrees(eight.elevation):.1f} +- {math.degrees(eight.half_height):.1f} deg, "
          f"{'up' if eight.direction > 0 else 'down'} through the middle")
    if plot:
        print(f"plot: {plot}")
    return 0


def _print_status(flight: Flight) -> None:
    row = flight.truth.last()
    if row is None:
        return
    cross_track, turning = flight.recent_errors(10.0)
    mode = "silent" if row.mode == MODE_UNKNOWN else mode_name(int(row.mode))
    warning = "  UNSTABLE: lower INNER_P" if mode == "TRACK" and turning > UNSTABLE_TURNING_ANGLE else ""
    say(f"{row.time_s:6.0f} s  {mode:7}  cross-track {math.degrees(cross_track):5.2f} deg  "
        f"turning angle {math.degrees(turning):6.1f} deg (RMS of 10 s)  steering {row.steering:+.3f}  "
        f"overruns {flight.overruns}{warning}")


def report(result: RunResult, as_json: bool) -> None:
    """Print the numbers of a flight, for a person or a script."""
    numbers = result.numbers
    if as_json:
        print(json.dumps(numbers))
        return
    loop = f" ({numbers['loop']})" if numbers["runtime"] == "inproc" else ""
    print(f"{numbers['scenario']}: {numbers['sim_s']:.1f} s flown in {numbers['wall_s']:.2f} s "
          f"({numbers['real_time_factor']:.4g} times real time), {numbers['runtime']}{loop}, seed {numbers['seed']}"
          + (", interrupted" if result.interrupted else ""))
    if numbers["trouble"]:
        print(f"{numbers['verdict']}: {numbers['trouble']}")
    if numbers["cross_track_rms_rad"] is None:
        return
    print(f"{'in TRACK' if numbers['trouble'] else numbers['verdict']}: "
          f"cross-track {math.degrees(numbers['cross_track_rms_rad']):.2f} deg RMS, "
          f"{math.degrees(numbers['cross_track_max_rad']):.2f} deg peak; turning angle "
          f"{math.degrees(numbers['turning_angle_rms_rad']):.1f} deg RMS; steering {numbers['steering_rms']:.3f} RMS, "
          f"at its limit {100 * numbers['saturated_fraction']:.0f} % of the time; "
          f"{numbers['ticks']} ticks, {numbers['overruns']} overruns")
    _report_loads(numbers)


def _report_loads(numbers: dict[str, Any]) -> None:
    """What actuator, tether and the room above ground had to bear."""
    said = [f"least elevation {math.degrees(numbers['least_elevation_rad']):.1f} deg"]
    if numbers["steering_travel_per_s"] is not None:
        said.insert(0, f"steering travel {numbers['steering_travel_per_s']:.3f} per second, "
                       f"{numbers['steering_asked_travel_per_s']:.3f} commanded")
    if numbers["peak_tether_force_n"] is not None:
        said.append(f"peak tether force {numbers['peak_tether_force_n']:.0f} N")
    print("; ".join(said))


