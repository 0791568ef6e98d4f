"""The program `kite-sitl`: fly simulated kites with the real firmware, plot and compare."""

import argparse
import os
import signal
import sys
from collections.abc import Sequence
from typing import Any

from kite_analysis.console.mistakes import Parser
from kite_analysis.console.optional_packages import ExtraMissingError
from kite_analysis.flights.description import FlightDataError
from kite_analysis.metrics import RULE
from kite_analysis.picture_file import FileRefusedError
from sim_bridge.boards.image import BoardError
from sim_bridge.cli import actions
from sim_bridge.cli.boards import add_board_verbs
from sim_bridge.cli.design import add_design_verb
from sim_bridge.cli.identify import add_identify_verb
from sim_bridge.cli.notes import DISK_TROUBLE
from sim_bridge.cli.option_types import add_interpreter_option, not_negative, positive
from sim_bridge.cli.plot_option import add_plot_option, leave_words_to_others
from sim_bridge.cli.rerun import add_rerun_verb
from sim_bridge.cli.sweep import add_sweep_verb
from sim_bridge.cli.validate import add_validate_verb
from sim_bridge.errors import ScenarioError
from sim_bridge.runs.run import FOREVER_LIMIT_MB, RUNTIMES
from sim_bridge.runtimes.interface import FirmwareError
from sim_bridge.scenario.keys import PLANTS


def _speed(text: str) -> float:
    return float("inf") if text == "max" else positive(text)


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="kite-sitl", description="Fly simulated kites with the real firmware.",
        epilog="Start with: kite-sitl run paper-delay-tuned --plot")
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")

    listing = verbs.add_parser("list", help="list the scenarios that come with kitepilot")
    listing.set_defaults(do=actions.list_scenarios)
    keys = verbs.add_parser("keys", help="list every key for --set and scenario files")
    keys.set_defaults(do=actions.list_keys)

    _add_run(verbs)
    add_rerun_verb(verbs)

    paper = verbs.add_parser("paper", help="reproduce the paper's figures, and a table of their numbers")
    paper.add_argument("--out", metavar="DIR", default="paper", help="folder to write into (default: paper)")
    paper.add_argument("--plant", choices=PLANTS, default="turning-rate",
                       help="the plant to fly, with its own set of tether, eight and gains (default: turning-rate)")
    paper.add_argument("--force", action="store_true", help="overwrite existing figures")
    paper.set_defaults(do=actions.paper)

    shadow = verbs.add_parser(
        "shadow", help="run the firmware as the shadow of a real flight",
        description="Feed the samples of a recorded flight to the firmware over MAVLink, and compare the turning angle "
        "that it finds from positions alone with the recorded course. Its steering has no effect.")
    shadow.add_argument("file", metavar="FILE", help="a flight, CSV or CSV.gz")
    shadow.add_argument("--columns", metavar="FILE.toml", help="what the columns of FILE mean "
                        "(docs/flight-files.md; default: those of the public V3 flight)")
    shadow.add_argument("--runtime", choices=RUNTIMES, default="cpython", help="default: cpython")
    add_interpreter_option(shadow)
    add_plot_option(shadow, "plot the firmware's turning angle and the recorded one", "NAME-shadow.png here")
    shadow.set_defaults(do=actions.shadow)

    bench = verbs.add_parser("bench", help="measure the speed of the loop on this machine")
    bench.add_argument("--runtime", choices=("inproc", "micropython"), default="inproc",
                       help="inproc: simulation speed; micropython: memory and time of a tick (default: inproc)")
    add_interpreter_option(bench)
    bench.add_argument("--scenario", metavar="NAME",
                       help="scenario to fly (default: paper-delay-tuned; small-kite for micropython)")
    bench.add_argument("--duration", type=positive, metavar="S",
                       help="simulated seconds (default: 60; 600 for micropython)")
    bench.set_defaults(do=actions.bench)
    add_sweep_verb(verbs)
    add_validate_verb(verbs)
    add_design_verb(verbs)
    add_identify_verb(verbs)
    add_board_verbs(verbs)
    for verb in (listing, keys, paper, shadow, bench):
        verb.add_argument("--json", action="store_true", help="print JSON for a script")
    return parser


def _add_run(verbs: Any) -> None:
    run = verbs.add_parser(
        "run", help="fly a scenario", formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Fly a scenario by its name, or from a TOML file by its path.\n\n"
        "With --log the flight is recorded as it goes; a crash costs at most the last second. A full disk ends the\n"
        "log, not the flight. `kite-sitl rerun DIR` flies it again.",
        epilog=f"verdict: {RULE}\n\nexamples:\n"
        "  kite-sitl run paper-delay --json\n"
        "  kite-sitl run paper-delay --param INNER_P=1.84 --plot\n"
        "  kite-sitl run small-kite --set link.control.jitter_s=0.03 --set link.control.loss=0.05 --seed 7\n"
        "  kite-sitl run small-kite --runtime micropython --interpreter ./micropython-f32\n"
        "  kite-sitl run v3-flight --runtime cpython --speed 1 --ground --status --forever")
    run.add_argument("--runtime", choices=RUNTIMES,
                     help="where the firmware runs: in this process, or in its own "
                     "(default: inproc; with --ground cpython)")
    add_interpreter_option(run)
    run.add_argument("--speed", type=_speed, default=float("inf"), metavar="max|N",
                     help="max: as fast as it goes, in lockstep; N: N times real time; "
                     "1 in its own process: real time, on the firmware's own clock (default: max)")
    run.set_defaults(do=actions.run)
    hil = verbs.add_parser(
        "hil", help="let a real board fly the simulated kite", formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Hardware in the loop: a board with SENSORS = 'hil' flies the simulated kite in real time,\n"
        "through its own link. The scenario's parameters are loaded into the board. The board's own delay is\n"
        "measured, and the emulated delay shortened by it.",
        epilog="The verdict is explained by `kite-sitl run --help`.\n\nexamples:\n"
        "  kite-sitl hil --link serial:/dev/ttyACM0:115200 small-kite --status\n"
        "  kite-sitl hil --link udp:0.0.0.0:14555 v3-flight --ground --forever")
    hil.add_argument("--link", required=True, metavar="LINK",
                     help="serial:DEVICE:BAUD, or udp:HOST:PORT, the address that the board sends to")
    hil.set_defaults(do=actions.hil)
    for verb in (run, hil):
        _add_flight(verb)


def _add_flight(verb: argparse.ArgumentParser) -> None:
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
    add_plot_option(verb, "plot the flight", "NAME.png here, or in the run log's folder")
    verb.add_argument("--json", action="store_true", help="print the result as JSON")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `kite-sitl` with `arguments`; return the exit code: 2 for what the user can put right."""
    words = sys.argv[1:] if arguments is None else arguments
    options = _parser().parse_args(leave_words_to_others(words))
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # end as cleanly as on Ctrl-C
    try:
        code = options.do(options)
        sys.stdout.flush()
        return code
    except (ScenarioError, FlightDataError, FirmwareError, ExtraMissingError, FileRefusedError, BoardError) as error:
        print(f"kite-sitl: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        sys.stderr.close()  # whoever read us has had enough
        return 0
    except OSError as error:
        if error.errno not in DISK_TROUBLE:
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what is left could not be written either
        print(f"kite-sitl: cannot write the output: {error.strerror}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
