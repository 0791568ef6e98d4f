"""kite-ground: the ground station's command line.

Exit codes: 0 done, 1 the vehicle refused or did not answer, 2 wrong input or no vehicle heard, 130 interrupted.
"""

import argparse
import os
import sys
from typing import TYPE_CHECKING

from ground.cli.options import DEFAULTS, add_link_options
from ground.cli.terminal import tell
from ground.cli.verbs import VERBS
from ground.errors import GroundError
from kite_analysis.console.mistakes import Parser
from kite_analysis.console.verbs import add_verbs

if TYPE_CHECKING:
    from ground.session import Session


def main(argv: list[str] | None = None) -> int:
    """Run kite-ground with `argv` (default: the process's arguments) and return its exit code."""
    def connect() -> "Session":
        from ground.cli.connect import open_session  # noqa: PLC0415  most of kite-ground, which --help can do without

        return open_session(args)

    try:
        parser = build_parser()
        args = parser.parse_args(argv, argparse.Namespace(**DEFAULTS, whole_parser=parser))
        code = args.run(args, connect)
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
    """The parser; the verb that is chosen sets `run(args, connect)`, which does the work and returns the exit code."""
    parser = Parser(prog="kite-ground", description="Ground station for kites that fly with kitepilot.",
                    epilog="example:\n  kite-ground --link udpin:0.0.0.0:14550 monitor")
    add_link_options(parser, 0)
    add_verbs(parser, VERBS)
    return parser
