"""What the subcommands of kite-ground share: options, their defaults, and how a parser answers mistakes."""

import argparse
import difflib
import math
from collections.abc import Callable, Iterable
from typing import NoReturn

from ground.errors import UsageError
from ground.session import Session

DEFAULTS = {"link": "udpin:127.0.0.1:14550", "timeout": 10.0, "system": None}

Connect = Callable[[], Session]
Run = Callable[[argparse.Namespace, Connect], int]


class Parser(argparse.ArgumentParser):
    """An argument parser that answers a mistake in one line, and shows examples as they are written."""

    def __init__(self, *args, **keywords) -> None:
        super().__init__(*args, allow_abbrev=False, formatter_class=argparse.RawDescriptionHelpFormatter, **keywords)

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}; {self.prog} --help shows how\n")


def common_options() -> argparse.ArgumentParser:
    """Options that may stand before or after the subcommand."""
    parser = argparse.ArgumentParser(add_help=False, argument_default=argparse.SUPPRESS)
    group = parser.add_argument_group("link")
    group.add_argument("--link", metavar="LINK", help="udpin:HOST:PORT waits for the vehicle, udpout:HOST:PORT calls "
                       f"it, serial:DEVICE:BAUD is a cable or radio (default {DEFAULTS['link']})")
    group.add_argument("--timeout", type=positive, metavar="S",
                       help=f"seconds to wait for the vehicle's heartbeat (default {DEFAULTS['timeout']:g})")
    group.add_argument("--system", type=int, choices=range(1, 256), metavar="ID",
                       help="system id of the vehicle (default: the first one heard)")
    return parser


def add_command(commands, name: str, run: Run, summary: str, examples: str) -> argparse.ArgumentParser:
    """Add a subcommand with the common options; `examples` are lines to show below its help."""
    parser = commands.add_parser(name, help=summary, description=summary[0].upper() + summary[1:] + ".",
                                 epilog=f"example:\n{examples}", parents=[common_options()])
    parser.set_defaults(run=run)
    return parser


def positive(text: str) -> float:
    """A positive, finite number, as an argument type."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} should be more than 0, and finite")
    return value


def closest(word: str, known: Iterable[str]) -> str:
    """A half sentence that suggests the known word closest to `word`, or nothing."""
    near = difflib.get_close_matches(word, list(known), n=1, cutoff=0.5)
    return f"; did you mean {near[0]}?" if near else ""


def known_name(name: str, known: Iterable[str]) -> str:
    """`name` in capitals. Raises UsageError, with the closest name, when it is not among the known ones."""
    known = list(known)
    if name.upper() not in known:
        raise UsageError(f"no parameter is called {name!r}{closest(name.upper(), known)}")
    return name.upper()
