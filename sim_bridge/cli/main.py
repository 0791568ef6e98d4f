"""The program `kite-sitl`: fly simulated kites with the real firmware, plot and compare."""

import os
import signal
import sys
from collections.abc import Sequence

from kite_analysis.console.mistakes import Parser
from kite_analysis.console.optional_packages import ExtraMissingError
from kite_analysis.console.verbs import add_verbs
from kite_analysis.flights.description import FlightDataError
from kite_analysis.picture_file import FileRefusedError
from sim_bridge.cli.notes import DISK_TROUBLE, notice
from sim_bridge.cli.plot_option import leave_words_to_others
from sim_bridge.cli.verbs import VERBS
from sim_bridge.errors import BoardError, FirmwareError, ScenarioError
from sim_bridge.native.choice import choose_loop


def build_parser() -> Parser:
    """The parser; the verb that is chosen sets `run(options)`, which does the work and returns the exit code."""
    parser = Parser(
        prog="kite-sitl", description="Fly simulated kites with the real firmware.",
        epilog="Start with: kite-sitl run paper-delay-tuned --plot")
    add_verbs(parser, VERBS)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `kite-sitl` with `arguments`; return the exit code: 2 for what the user can put right.

    What flies (firmware, plants, links and all else of a flight) is imported by `options.run`, and not before: whether
    it is compiled is chosen here.
    """
    words = sys.argv[1:] if arguments is None else arguments
    options = build_parser().parse_args(leave_words_to_others(words))
    # Matrices here are small: threads that wait for a share of one would take the cores from flights, and double a
    # sweep's time.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # end as cleanly as on Ctrl-C
    if hasattr(options, "interpreted") and (problem := choose_loop(options.interpreted)):
        notice(problem)
    try:
        code = options.run(options)
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
