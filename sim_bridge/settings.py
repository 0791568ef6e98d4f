"""Settings of a part: frozen, checked when they are made, with defaults, units and bounds beside each field.

    @dataclass(frozen=True, kw_only=True)
    class ActuatorSettings(Settings):
        dead_time_s: float = number(0.0, "dead time from command to actual steering [s]", 0.0, 5.0)

    ActuatorSettings(dead_time_s=7.0)  # ValueError: ActuatorSettings: dead_time_s = 7 is outside 0 to 5

The table of a scenario's keys is made of these types; see scenario/keys.
"""

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import Field, dataclass, field, fields
from functools import cache
from typing import Any, NamedTuple

Value = float | int | bool | str | tuple[float, ...] | None
_KEY = "key"
_KINDS = {float: "a number", int: "a whole number", bool: "true or false", str: "text"}


class Key(NamedTuple):
    """One setting: numbers lie between `least` and `greatest`, text is one of `choices` (any, if there are none).

    `kind` tuple is a list of numbers.
    """

    default: Value
    text: str
    least: float = 0.0
    greatest: float = float("inf")
    choices: Sequence[str] = ()
    kind: type = float

    def takes(self) -> str:
        """What it takes, in words: bounds, choices, or the kind of its value."""
        if self.choices:
            return ", ".join(self.choices)
        if self.kind in (bool, str):
            return "true, false" if self.kind is bool else "text"
        bounds = f"{self.least:g} or more" if self.greatest == float("inf") else f"{self.least:g} to {self.greatest:g}"
        return f"numbers, {bounds}" if self.kind is tuple else bounds

    def read(self, name: str, text: str) -> Value:
        """The value of `text`, as typed on a command line; its bounds are not looked at.

        Raises:
            ValueError: it is none of this kind; says so in one line with the key's `name`.
        """
        if self.kind is bool:
            if text.lower() not in ("true", "false"):
                raise ValueError(f"{name} takes true or false")
            return text.lower() == "true"
        if self.kind is int:
            value = read_number(text)
            if not value.is_integer():
                raise ValueError(f"{name} takes a whole number")
            return int(text) if text.lstrip("+-").isdigit() else int(value)
        if self.kind is tuple:
            return tuple(read_number(part.strip()) for part in text.split(","))
        return read_number(text) if self.kind is float else text

    def checked(self, name: str, value: Any) -> Value:
        """`value` as it is kept: whole numbers as floats where a float is wanted, a list as a tuple.

        Raises:
            ValueError: it cannot be taken; says so in one line with the key's `name`, the value and the bounds.
        """
        if self.kind is tuple:
            return self._checked_numbers(name, value)
        if self.kind is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if not isinstance(value, self.kind) or (self.kind is int and isinstance(value, bool)):
            raise ValueError(f"{name} takes {_KINDS[self.kind]}, not {value!r}")
        if self.choices and value not in self.choices:
            raise ValueError(f"{name} is one of {', '.join(self.choices)}{near_miss(str(value), self.choices)}")
        if self.kind in (float, int) and not self.least <= value <= self.greatest:
            raise ValueError(f"{name} = {value:g} is outside {self.least:g} to {self.greatest:g}")
        return value

    def _checked_numbers(self, name: str, value: Any) -> tuple[float, ...]:
        if not isinstance(value, list | tuple) or not value:
            raise ValueError(f"{name} takes a list of numbers, not {value!r}")
        for number in value:
            if isinstance(number, bool) or not isinstance(number, int | float):
                raise ValueError(f"{name} takes numbers, not {number!r}")
            if not self.least <= number <= self.greatest:
                raise ValueError(f"{name}: {number:g} is outside {self.least:g} to {self.greatest:g}")
        return tuple(float(number) for number in value)


def number(default: float | None, text: str, least: float = 0.0, greatest: float = float("inf")) -> Any:
    """A field that takes a number; one whose `default` is None may be left unset."""
    return _setting(Key(default, text, least, greatest))


def whole_number(default: int, text: str, least: int, greatest: int) -> Any:
    """A field that takes a whole number."""
    return _setting(Key(default, text, least, greatest, kind=int))


def numbers(default: tuple[float, ...], text: str, bound: float) -> Any:
    """A field that takes a list of numbers, each from -`bound` to `bound`."""
    return _setting(Key(default, text, -bound, bound, kind=tuple))


def flag(default: bool, text: str) -> Any:
    """A field that takes True or False."""
    return _setting(Key(default, text, kind=bool))


def words(default: str, text: str, choices: Sequence[str] = ()) -> Any:
    """A field that takes text: one of `choices`, or any where there are none."""
    return _setting(Key(default, text, choices=choices, kind=str))


def part(kind: type["Settings"]) -> Any:
    """A field that holds the settings of a part, all at their defaults unless others are given."""
    return field(default=kind())


def _setting(key: Key) -> Any:
    return field(default=key.default, metadata={_KEY: key})


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What all settings have in common: they are checked, and their docstring lists the fields with their bounds.

    A field is made by `number` and its like, or by `part`.

    Raises:
        ValueError: a value that cannot be taken; says in one line which, and what could be.
    """

    def __init_subclass__(cls) -> None:
        own = {name: made.metadata[_KEY] for name, made in vars(cls).items()
               if isinstance(made, Field) and _KEY in made.metadata}
        if own:
            lines = (f"{name}: {key.text} ({key.takes()}; default {key.default})" for name, key in own.items())
            cls.__doc__ = "\n    ".join([f"{(cls.__doc__ or '').rstrip()}\n", *lines])

    def __post_init__(self) -> None:
        for name, key in own_keys(type(self)).items():
            value = getattr(self, name)
            if value is None and key.default is None:
                continue
            try:
                object.__setattr__(self, name, key.checked(name, value))
            except ValueError as error:
                raise ValueError(f"{type(self).__name__}: {error}") from None


@cache
def own_keys(kind: type[Settings]) -> dict[str, Key]:
    """What is known of the fields of `kind`, without those of its parts, by name."""
    return {made.name: made.metadata[_KEY] for made in fields(kind) if _KEY in made.metadata}


@cache
def parts(kind: type[Settings]) -> dict[str, type[Settings]]:
    """The types of the settings that `kind` holds, by the name of their field."""
    return {made.name: type(made.default) for made in fields(kind) if isinstance(made.default, Settings)}


def near_miss(name: str, known: Iterable[str]) -> str:
    """The end of a message about `name`, which is not `known`: what was meant, if that can be seen."""
    near = difflib.get_close_matches(name, list(known), 1, 0.5)
    return f"; did you mean {near[0]}?" if near else ""


def read_number(text: str) -> float:
    """The number that `text` is.

    Raises:
        ValueError: it is none; says so in one line.
    """
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{text!r} is not a number") from None
