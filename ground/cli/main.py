"""kite-ground: the ground station's command line.

Exit codes: 0 done, 1 the vehicle refused or did not answer, 2 wrong input or no vehicle heard, 130 interrupted.
"""

import argparse
import os
import sys
import time

from ground.cli.completion import add_completion_verb
from ground.cli.logs import add_log_verbs
from ground.cli.options import DEFAULTS, common_options, link_names
from ground.cli.parameters import add_parameter_verbs
from ground.cli.record import add_record_verb
from ground.cli.terminal import tell
from ground.cli.tune import add_tune_verb
from ground.cli.vehicle import add_vehicle_verbs
from ground.errors import GroundError
from ground.link.links import open_links
from ground.session import Session
from kite_analysis.console.mistakes import Parser


def main(argv: list[str] | None = None) -> int:
    """Run kite-ground with `argv` (default: the process's arguments) and return its exit code."""
    try:
        parser = build_parser()
        args = parser.parse_args(argv, argparse.Namespace(**DEFAULTS, whole_parser=parser))
        code = args.run(args, lambda: open_session(args))
        sys.stdout.flush()
        return code
    except SystemExit as leaving:  # argparse has printed the reason
        return leaving.code if isinstance(leaving.code, int) else 2
    except GroundError as error:
        tell(f"kite-ground: {error}")
        return error.exit_code
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or Python prints an error when it exits
        return 0
    except OSError as error:
        tell(f"kite-ground: {error.filename or 'input or output'}: {error.strerror or error}")
        return 1
    except KeyboardInterrupt:
        tell("\nkite-ground: interrupted")
        return 130


def build_parser() -> Parser:
    """The parser of all verbs; each sets `run(args, connect)`, which does the work and returns the exit code."""
    parser = Parser(prog="kite-ground", description="Ground station for kites that fly with kitepilot.",
                    parents=[common_options(0)], epilog="example:\n  kite-ground --link udpin:0.0.0.0:14550 monitor")
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    add_vehicle_verbs(verbs)
    add_parameter_verbs(verbs)
    add_tune_verb(verbs)
    add_record_verb(verbs)
    add_log_verbs(verbs)
    add_completion_verb(verbs)
    return parser


def open_session(args: argparse.Namespace) -> Session:
    """Open the links of `args` and wait for its vehicle. Raises LinkError or UsageError if that fails."""
    session = Session(open_links(link_names(args), time.monotonic, tell), tell, args.system)
    try:
        session.find_vehicle(args.timeout)
    except BaseException:
        session.links.close()
        raise
    return session
