"""Options of `kite-sitl run`, `hil` and `rerun`."""

from argparse import ArgumentParser

from kite_analysis.verdicts import RULE
from sim_bridge.cli.option_types import add_interpreter_option, add_loop_option, not_negative, positive
from sim_bridge.cli.plot_option import add_plot_option
from sim_bridge.runs.run_choices import FOREVER_LIMIT_MB, RUNTIMES


def add_run_options(verb: ArgumentParser) -> None:
    """Options of `run`."""
    verb.description = (
        "Fly a scenario by its name, or from a TOML file by its path.\n\n"
        "With --log the flight is recorded as it goes; a crash costs at most the last second. A full disk ends the\n"
        "log, not the flight. `kite-sitl rerun DIR` flies it again.")
    verb.epilog = (
        f"verdict: {RULE}\n\nexamples:\n"
        "  kite-sitl run paper-delay --json\n"
        "  kite-sitl run paper-delay --param INNER_P=1.84 --plot\n"
        "  kite-sitl run small-kite --set link.control.jitter_s=0.03 --set link.control.loss=0.05 --seed 7\n"
        "  kite-sitl run small-kite --runtime micropython --interpreter ./micropython-f32\n"
        "  kite-sitl run v3-flight --runtime cpython --speed 1 --ground --status --forever")
    verb.add_argument("--runtime", choices=RUNTIMES,
                      help="where the firmware runs: in this process, or in its own "
                      "(default: inproc; with --ground cpython)")
    add_interpreter_option(verb)
    verb.add_argument("--speed", type=_speed, default=float("inf"), metavar="max|N",
                      help="max: as fast as it goes, in lockstep; N: N times real time; "
                      "1 in its own process: real time, on the firmware's own clock (default: max)")
    _add_flight(verb)


def add_hil_options(verb: ArgumentParser) -> None:
    """Options of `hil`."""
    verb.description = (
        "Hardware in the loop: a board with SENSORS = 'hil' flies the simulated kite in real time,\n"
        "through its own link. The scenario's parameters are loaded into the board. The board's own delay is\n"
        "measured, and the emulated delay shortened by it.")
    verb.epilog = (
        "The verdict is explained by `kite-sitl run --help`.\n\nexamples:\n"
        "  kite-sitl hil --link serial:/dev/ttyACM0:115200 small-kite --status\n"
        "  kite-sitl hil --link udp:0.0.0.0:14555 v3-flight --ground --forever")
    verb.add_argument("--link", required=True, metavar="LINK",
                      help="serial:DEVICE:BAUD, or udp:HOST:PORT, the address that the board sends to")
    _add_flight(verb)


def add_rerun_options(verb: ArgumentParser) -> None:
    """Options of `rerun`."""
    verb.description = """\
Fly the run logged in DIR again, with everything that ground stations sent, and compare every tick.

All values come from the log, defaults and wind file included. Code, versions and defaults that differ here are
reported first. A truncated log (Ctrl-C, kill, a full disk, a firmware that died) is repeated up to its last tick.
Real-time runs cannot be repeated to the bit.

Exit 0: the same to the bit; 1: a number differs; 2: it cannot be flown again."""
    verb.add_argument("folder", metavar="DIR", help="a folder that `run --log` wrote")
    add_interpreter_option(verb, "the logged one, while it is there")
    add_loop_option(verb)
    verb.add_argument("--json", action="store_true", help="print JSON for a script")


def _add_flight(verb: ArgumentParser) -> None:
    """What a flight takes, wherever the firmware is."""
    verb.add_argument("scenario", metavar="NAME", help="a scenario of `kite-sitl list`, or a .toml file")
    verb.add_argument("--set", action="append", default=[], metavar="section.key=value",
                      help="change a key of the scenario (see `kite-sitl keys`)")
    verb.add_argument("--param", action="append", default=[], metavar="NAME=value", help="change a firmware parameter")
    verb.add_argument("--seed", type=int, help="seed of all random numbers (run.seed)")
    length = verb.add_mutually_exclusive_group()
    length.add_argument("--duration", type=positive, metavar="S", help="length of the flight (run.duration_s)")
    length.add_argument("--forever", action="store_true", help="fly until Ctrl-C")
    verb.add_argument("--ground", action="store_true",
                      help="open the ground path: ground stations find the kite on UDP 127.0.0.1:14550")
    verb.add_argument("--log", metavar="DIR",
                      help="write the run log into this new folder, as the flight goes (see docs/run-log.md)")
    verb.add_argument("--log-limit", type=not_negative, metavar="MB",
                      help="keep the log below this size by dropping its oldest part; 0 is no limit "
                      f"(default: {FOREVER_LIMIT_MB:g} with --forever, else none)")
    verb.add_argument("--status", action="store_true", help="print a status line for each second of flight")
    add_loop_option(verb)
    add_plot_option(verb, "plot the flight", "NAME.png here, or in the run log's folder")
    verb.add_argument("--json", action="store_true", help="print the result as JSON")


def _speed(text: str) -> float:
    return float("inf") if text == "max" else positive(text)
