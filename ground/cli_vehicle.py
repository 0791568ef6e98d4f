"""kite-ground monitor, mode, arm, disarm, tune and record."""

import argparse
import contextlib
import json
import sys
import time

from ground.cli_options import Connect, add_command, positive
from ground.errors import VehicleError
from ground.monitor import monitor
from ground.parameter_file import format_value
from ground.recorder import Recorder
from ground.session import Session
from ground.terminal import confirm, tell
from ground.tuning import GAIN_NAME, RATE_NAME, GainAdvice, advise, as_dictionary, check_proposal, describe
from ground.vehicle_state import MODE_NAMES


def add_vehicle_commands(commands) -> None:
    """Add the subcommands that watch, command and tune the vehicle."""
    watch = add_command(commands, "monitor", show_monitor, "show the vehicle live: a table in a terminal, a line a "
                        "second in a pipe", "  kite-ground monitor\n"
                        "  kite-ground --link serial:/dev/ttyACM0:115200 monitor")
    watch.add_argument("--duration", type=positive, metavar="S", help="stop after so many seconds")
    mode = add_command(commands, "mode", change_mode, "show the mode, or change it and wait until the vehicle is in it",
                       "  kite-ground mode track")
    mode.add_argument("mode", nargs="?", type=str.lower, metavar="MODE",
                      choices=[name.lower() for name in MODE_NAMES.values()],
                      help=", ".join(name.lower() for name in MODE_NAMES.values()))
    add_command(commands, "arm", arm, "arm, and wait until the vehicle is armed", "  kite-ground arm")
    add_command(commands, "disarm", disarm, "disarm, and wait until the vehicle is disarmed", "  kite-ground disarm")
    gain = add_command(commands, "tune", tune, f"work out {GAIN_NAME} for the delay in the loop, and set it",
                       "  kite-ground tune --delay 0.2")
    gain.add_argument("--delay", type=positive, required=True, metavar="S",
                      help="dead time tau of links and actuator together, without sampling, in seconds")
    gain.add_argument("--loop-hz", type=positive, metavar="N", help=f"loop rate (default: the vehicle's {RATE_NAME})")
    gain.add_argument("--yes", action="store_true", help="do not ask before setting it")
    gain.add_argument("--json", action="store_true", help="for a script; sets nothing without --yes")
    log = add_command(commands, "record", record, "record everything that is heard to a .tlog, until Ctrl-C",
                      "  kite-ground record flight.tlog")
    log.add_argument("file", metavar="FILE.tlog")
    log.add_argument("--force", action="store_true", help="write over a file that is there")
    log.add_argument("--duration", type=positive, metavar="S", help="stop after so many seconds")


def show_monitor(args: argparse.Namespace, connect: Connect) -> int:
    """monitor."""
    with connect() as session, contextlib.suppress(KeyboardInterrupt):
        monitor(session, sys.stdout, args.duration)
    return 0


def change_mode(args: argparse.Namespace, connect: Connect) -> int:
    """mode."""
    with connect() as session:
        if args.mode is not None:
            session.commander.set_mode(next(value for value, name in MODE_NAMES.items() if name.lower() == args.mode))
        print(f"mode {_state(session)}")
    return 0


def arm(args: argparse.Namespace, connect: Connect) -> int:
    """arm."""
    with connect() as session:
        session.commander.arm()
        print(f"mode {_state(session)}")
    return 0


def disarm(args: argparse.Namespace, connect: Connect) -> int:
    """disarm."""
    with connect() as session:
        session.commander.disarm()
        print(f"mode {_state(session)}")
    return 0


def tune(args: argparse.Namespace, connect: Connect) -> int:
    """tune."""
    with connect() as session:
        session.check_contract()
        loop_hz = args.loop_hz or session.parameters.fetch(RATE_NAME)
        advice = advise(args.delay, loop_hz, session.parameters.fetch(GAIN_NAME))
        if not args.json:
            print("\n".join(describe(advice)), flush=True)
        written = _write_gain(args, session, advice)
    if args.json:
        print(json.dumps({**as_dictionary(advice), "written": written}, indent=2))
    elif written:
        print(f"{GAIN_NAME} = {format_value(advice.proposal)} 1/s, acknowledged by the vehicle")
    else:
        print(f"{GAIN_NAME} stays as it is")
    return 0


def record(args: argparse.Namespace, connect: Connect) -> int:
    """record."""
    with connect() as session:
        offset_s = time.time() - session.connection.clock()
        with Recorder(session.connection, args.file, offset_s, args.force) as recorder:
            tell(f"recording to {args.file}; Ctrl-C ends")
            with contextlib.suppress(KeyboardInterrupt):
                session.connection.wait_until(lambda: False, args.duration or float("inf"))
    print(f"{recorder.frames} messages recorded to {args.file}")
    return 0


def _write_gain(args: argparse.Namespace, session: Session, advice: GainAdvice) -> bool:
    """Whether the proposal was written: it differs, it is safe, and the user agrees."""
    if advice.proposal == advice.present or (args.json and not args.yes):
        return False
    check_proposal(advice)
    if not args.yes and not confirm(session, f"set {GAIN_NAME} to {advice.proposal:.4g}, which is 1 / (e tau)?"):
        return False
    if session.parameters.set(GAIN_NAME, advice.proposal) != advice.proposal:
        raise VehicleError(f"{GAIN_NAME}: another value was acknowledged")
    return True


def _state(session: Session) -> str:
    return f"{session.state.mode_name}, {'armed' if session.state.armed else 'disarmed'}"
