"""kite-ground monitor, mode, arm and disarm."""

import argparse
import contextlib
import sys

from ground.cli.monitor import monitor
from ground.cli.options import Connect, begin_verb, positive
from ground.cli.snapshot_option import snapshot_store
from ground.cli.terminal import parameter_progress, tell
from ground.errors import GroundError
from ground.session import Session
from protocol.modes import MODE_NAMES


def add_monitor_options(verb: argparse.ArgumentParser) -> None:
    """Options of `monitor`."""
    begin_verb(verb, "  kite-ground monitor\n  kite-ground --link serial:/dev/ttyACM0:115200 monitor")
    verb.add_argument("--duration", type=positive, metavar="S", help="stop after this many seconds")


def add_mode_options(verb: argparse.ArgumentParser) -> None:
    """Options of `mode`."""
    begin_verb(verb, "  kite-ground mode track")
    verb.add_argument("mode", nargs="?", type=str.lower, metavar="MODE",
                      choices=[name.lower() for name in MODE_NAMES.values()],
                      help=", ".join(name.lower() for name in MODE_NAMES.values()))


def add_arm_options(verb: argparse.ArgumentParser) -> None:
    """Options of `arm`."""
    begin_verb(verb, "  kite-ground arm")


def add_disarm_options(verb: argparse.ArgumentParser) -> None:
    """Options of `disarm`."""
    begin_verb(verb, "  kite-ground disarm")


def show_monitor(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground monitor."""
    with connect() as session, contextlib.suppress(KeyboardInterrupt):
        monitor(session, sys.stdout, args.duration)
    return 0


def change_mode(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground mode."""
    with connect() as session:
        if args.mode is not None:
            session.commander.set_mode(next(value for value, name in MODE_NAMES.items() if name.lower() == args.mode))
        print(f"mode {_state(session)}")
    return 0


def arm(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground arm."""
    with connect() as session:
        was_armed = session.state.armed
        session.commander.arm()
        print(f"mode {_state(session)}", flush=True)
        if not was_armed:
            _begin_flight(args, session)
    return 0


def disarm(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground disarm."""
    with connect() as session:
        session.commander.disarm()
        print(f"mode {_state(session)}")
    return 0


def _begin_flight(args: argparse.Namespace, session: Session) -> None:
    """Save the present parameters for `param revert`. The kite is armed even if this fails."""
    try:
        snapshot_store(args, session).renew(parameter_progress())
    except GroundError as error:
        tell(f"warning: no snapshot of this flight's parameters: {error}")


def _state(session: Session) -> str:
    return f"{session.state.mode_name}, {'armed' if session.state.armed else 'disarmed'}"
