"""What is known of a key of a scenario."""

from collections.abc import Sequence
from typing import NamedTuple

Value = float | int | bool | str | tuple[float, ...] | None


class Key(NamedTuple):
    """One key: numbers lie between `least` and `greatest`, text is one of `choices` (any, if there are none).

    `kind` tuple is a list of numbers.
    """

    default: Value
    text: str
    least: float = 0.0
    greatest: float = float("inf")
    choices: Sequence[str] = ()
    kind: type = float


def number(default: float | None, text: str, least: float = 0.0, greatest: float = float("inf")) -> Key:
    """A key that takes a number."""
    return Key(default, text, least, greatest)
