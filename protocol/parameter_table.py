"""The parameter table of `parameters.toml`, read and checked.

One table serves both sides: the generator writes the firmware's copy from it, and the ground station and the
bridge read it here for units, limits and documentation.
"""

import tomllib
from functools import cache
from importlib import resources
from typing import NamedTuple

from protocol.single_precision import float32

_FLAGS = {"disarmed_only": False, "read_only": False, "off_at_zero": False}
_KEYS = {"default", "least", "greatest", "step", "unit", "group", "text", *_FLAGS}
NAME_LENGTH = 16


class Parameter(NamedTuple):
    """One parameter: `default`, `least`, `greatest` and `step` (0: any value) in `unit`.

    With `off_at_zero`, 0 is a value too, although `least` is above it.
    """

    name: str
    default: float
    least: float
    greatest: float
    step: float
    unit: str
    group: str
    text: str
    disarmed_only: bool
    read_only: bool
    off_at_zero: bool

    @property
    def range_text(self) -> str:
        """Least and greatest value, as a person is told: "0.5 to 50", "0 (off), 1.5 to 60"."""
        return f"{'0 (off), ' if self.off_at_zero else ''}{self.least:g} to {self.greatest:g}"

    def nearest(self, value: float) -> float:
        """The value in range that is nearest to `value`; 0 stays 0 where that means off."""
        return value if self.off_at_zero and not value else min(max(value, self.least), self.greatest)

    def problem_with(self, value: float) -> str | None:
        """Say in one line why `value` cannot be a value of this parameter, or return None."""
        rounded = float32(value)
        if self.off_at_zero and rounded == 0.0:
            return None
        if not self.least <= rounded <= self.greatest:  # also refuses NaN
            return f"{self.name} = {value:g} is outside {self.range_text} {self.unit}".rstrip()
        if self.step and (rounded - self.least) % self.step:
            return f"{self.name} = {value:g} is not {self.least:g} plus a multiple of {self.step:g}"
        return None


def parse_parameters(text: str) -> dict[str, Parameter]:
    """Read the text of a parameter table.

    Raises:
        ValueError: a name is too long, a key is unknown or missing, or a number is not exact in float32.
    """
    table = {}
    for name, entry in tomllib.loads(text).items():
        if not 1 <= len(name) <= NAME_LENGTH:
            raise ValueError(f"parameter {name}: a name has 1 to {NAME_LENGTH} characters")
        if unknown := set(entry) - _KEYS:
            raise ValueError(f"parameter {name}: unknown key {sorted(unknown)[0]}")
        if missing := _KEYS - {"step", *_FLAGS} - set(entry):
            raise ValueError(f"parameter {name}: missing key {sorted(missing)[0]}")
        parameter = Parameter(name, **{"step": 0.0, **_FLAGS, **entry})
        for number in parameter[1:5]:
            if float32(number) != number:
                raise ValueError(f"parameter {name}: {number} is not exact in float32")
        if problem := parameter.problem_with(parameter.default):
            raise ValueError(f"parameter {name}: default refused: {problem}")
        table[name] = parameter
    return table


@cache
def load_parameters() -> dict[str, Parameter]:
    """The project's table, by name, in the order of param_index; read once, so not to be changed."""
    return parse_parameters(resources.files("protocol").joinpath("parameters.toml").read_text("utf-8"))
