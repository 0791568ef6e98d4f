"""kite-ground: the ground station's command line.

Exit codes: 0 done, 1 the vehicle refused or did not answer, 2 what was given is wrong or no vehicle is heard,
130 interrupted.
"""

import argparse
import os
import sys
import time

from ground.cli_options import DEFAULTS, Parser, common_options
from ground.cli_parameters import add_parameter_commands
from ground.cli_vehicle import add_vehicle_commands
from ground.errors import GroundError
from ground.session import Session
from ground.terminal import tell
from ground.transport import open_transport


def main(argv: list[str] | None = None) -> int:
    """Run kite-ground with these arguments (the process's own when None) and return its exit code."""
    try:
        args = build_parser().parse_args(argv, argparse.Namespace(**DEFAULTS))
        code = args.run(args, lambda: open_session(args))
        sys.stdout.flush()
        return code
    except SystemExit as leaving:  # argparse has said what there was to say
        return leaving.code if isinstance(leaving.code, int) else 2
    except GroundError as error:
        tell(f"kite-ground: {error}")
        return error.exit_code
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or the interpreter complains at its end
        return 0
    except OSError as error:
        tell(f"kite-ground: {error.filename or 'input or output'}: {error.strerror or error}")
        return 1
    except KeyboardInterrupt:
        tell("\nkite-ground: interrupted")
        return 130


def build_parser() -> Parser:
    """The whole command line; each subcommand's `run(args, connect)` does its work and returns the exit code."""
    parser = Parser(prog="kite-ground", description="Ground station for a kite that flies with kitepilot.",
                    parents=[common_options()], epilog="example:\n  kite-ground --link udpin:0.0.0.0:14550 monitor")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    add_vehicle_commands(commands)
    add_parameter_commands(commands)
    return parser


def open_session(args: argparse.Namespace) -> Session:
    """Open the link of `args` and wait for its vehicle. Raises LinkError or UsageError when that fails."""
    session = Session(open_transport(args.link), time.monotonic, args.link, tell, args.system)
    try:
        session.find_vehicle(args.timeout)
    except BaseException:
        session.connection.close()
        raise
    return session
