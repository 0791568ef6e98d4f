"""Options that the verbs of kite-ground share, and their defaults."""

import argparse
import math
import time
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from ground.errors import UsageError
from kite_analysis.console.mistakes import closest

if TYPE_CHECKING:
    from ground.session import Session

DEFAULT_LINK = "udpin:127.0.0.1:14550"
DEFAULTS = {"timeout": 10.0, "system": None, "wall_clock": time.time}
_LEVELS = 3  # kite-ground, its verbs, the verbs of `param`: each level has its own --link

Connect = Callable[[], "Session"]


def add_link_options(parser: argparse.ArgumentParser, level: int = 2) -> None:
    """Options allowed before or after the verb; `level` is the parser's depth, 0 to 2."""
    group = parser.add_argument_group("link", argument_default=argparse.SUPPRESS)
    group.add_argument("--link", metavar="LINK", dest=f"link{level}", action="append",
                       help="udpin:HOST:PORT listens, udpout:HOST:PORT connects, serial:DEVICE:BAUD is a "
                       f"cable or radio; repeat to use several links at once (default {DEFAULT_LINK})")
    group.add_argument("--timeout", type=positive, metavar="S",
                       help=f"seconds to wait for the kite's heartbeat (default {DEFAULTS['timeout']:g})")
    group.add_argument("--system", type=int, choices=range(1, 256), metavar="ID",
                       help="system id of the kite (default: the first one heard)")


def add_group_link_options(group: argparse.ArgumentParser) -> None:
    """Options between a group's name and the verb in it."""
    add_link_options(group, 1)


def link_names(args: argparse.Namespace) -> list[str]:
    """The links given by --link, at any level."""
    names = [name for level in range(_LEVELS) for name in getattr(args, f"link{level}", [])]
    return names or [DEFAULT_LINK]


def begin_verb(verb: argparse.ArgumentParser, examples: str) -> None:
    """Give a verb that talks to the kite the options of the link; `examples` are lines below its help."""
    add_link_options(verb)
    add_examples(verb, examples)


def add_examples(verb: argparse.ArgumentParser, examples: str) -> None:
    """Put `examples` below a verb's help."""
    verb.epilog = f"example:\n{examples}"


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
