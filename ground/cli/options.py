"""Options that the verbs of kite-ground share, and their defaults."""

import argparse
import math
import time
from collections.abc import Callable, Iterable

from ground.errors import UsageError
from ground.parameters.snapshot import SnapshotStore
from ground.session import Session
from kite_analysis.console.mistakes import closest

DEFAULT_LINK = "udpin:127.0.0.1:14550"
DEFAULTS = {"timeout": 10.0, "system": None, "wall_clock": time.time}
_LEVELS = 3  # kite-ground, its verbs, the verbs of `param`: each level has its own --link

Connect = Callable[[], Session]
Run = Callable[[argparse.Namespace, Connect], int]


def common_options(level: int = 2) -> argparse.ArgumentParser:
    """Options allowed before or after the verb; `level` is the parser's depth, 0 to 2."""
    parser = argparse.ArgumentParser(add_help=False, argument_default=argparse.SUPPRESS)
    group = parser.add_argument_group("link")
    group.add_argument("--link", metavar="LINK", dest=f"link{level}", action="append",
                       help="udpin:HOST:PORT listens, udpout:HOST:PORT connects, serial:DEVICE:BAUD is a "
                       f"cable or radio; repeat to use several links at once (default {DEFAULT_LINK})")
    group.add_argument("--timeout", type=positive, metavar="S",
                       help=f"seconds to wait for the kite's heartbeat (default {DEFAULTS['timeout']:g})")
    group.add_argument("--system", type=int, choices=range(1, 256), metavar="ID",
                       help="system id of the kite (default: the first one heard)")
    return parser


def link_names(args: argparse.Namespace) -> list[str]:
    """The links given by --link, at any level."""
    names = [name for level in range(_LEVELS) for name in getattr(args, f"link{level}", [])]
    return names or [DEFAULT_LINK]


def add_snapshot_option(parser: argparse.ArgumentParser) -> None:
    """Add --snapshot."""
    parser.add_argument("--snapshot", metavar="FILE", help="file of the snapshot that `param revert` restores "
                        "(default: one per kite, in the user's state folder)")


def snapshot_store(args: argparse.Namespace, session: Session) -> SnapshotStore:
    """The snapshot of the session's vehicle, in the file of --snapshot (for verbs that have it) or the default."""
    return SnapshotStore(session.parameters, session.notice, getattr(args, "snapshot", None), args.wall_clock)


def add_verb(verbs, name: str, run: Run, summary: str, examples: str) -> argparse.ArgumentParser:
    """Add a verb with the common options; `examples` are lines below its help."""
    parser = verbs.add_parser(name, help=summary, description=summary[0].upper() + summary[1:] + ".",
                              epilog=f"example:\n{examples}", parents=[common_options()])
    parser.set_defaults(run=run)
    return parser


def positive(text: str) -> float:
    """Argument type: a positive, finite number."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} must be more than 0, and finite")
    return value


def known_name(name: str, known: Iterable[str]) -> str:
    """`name` in upper case. Raises UsageError, with the closest name, if it is not known."""
    known = list(known)
    if name.upper() not in known:
        raise UsageError(f"no parameter is called {name!r}{closest(name.upper(), known)}")
    return name.upper()
