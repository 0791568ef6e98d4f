"""Description of a scenario's key."""

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

    def takes(self) -> str:
        """Valid values, in words: bounds, choices, or type."""
        if self.choices:
            return ", ".join(self.choices)
        if self.kind in (bool, str):
            return "true, false" if self.kind is bool else "text"
        bounds = f"{self.least:g} or more" if self.greatest == float("inf") else f"{self.least:g} to {self.greatest:g}"
        return f"numbers, {bounds}" if self.kind is tuple else bounds


def number(default: float | None, text: str, least: float = 0.0, greatest: float = float("inf")) -> Key:
    """A key that takes a number."""
    return Key(default, text, least, greatest)
