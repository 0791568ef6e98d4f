"""The axes of a sweep, as typed, and the runs that they define."""

import math
from collections.abc import Sequence
from itertools import product
from random import Random
from typing import NamedTuple

from sim_bridge.errors import ScenarioError
from sim_bridge.scenario.scenario import Scenario

_PARAMETER = "param."


class Axis(NamedTuple):
    """Values of one key: `section.key`, or `param.NAME`. `is_range` if numbers between them make sense too."""

    key: str
    values: tuple[str, ...]
    is_range: bool
    logarithmic: bool = False

    def sample(self, random: Random) -> str:
        """A value: anywhere between the ends of a range, else one of those listed."""
        if not self.is_range:
            return random.choice(self.values)
        low, high = float(self.values[0]), float(self.values[-1])
        return repr(_between(low, high, random.random(), self.logarithmic))


def parse_axis(text: str) -> Axis:
    """Read KEY=FIRST:LAST:COUNT, KEY=FIRST:LAST:COUNT:log, or KEY=A,B,C.

    Raises:
        ScenarioError: it cannot be read, with what would be right.
    """
    key, equals, values = (part.strip() for part in text.partition("="))
    if not equals or not key or not values:
        raise ScenarioError(f"--over {text}: write KEY=FIRST:LAST:COUNT or KEY=A,B,C")
    if ":" not in values:
        return Axis(key, tuple(part.strip() for part in values.split(",")), False)
    try:
        first, last, count, *kind = values.split(":")
        low, high, number = float(first), float(last), int(count)
    except ValueError:
        raise ScenarioError(f"--over {text}: write FIRST:LAST:COUNT with numbers, as in 1:10:20") from None
    if not (math.isfinite(low) and math.isfinite(high)) or number < 1 or (number == 1 and low != high):
        raise ScenarioError(f"--over {text}: needs two finite ends and a count of at least 2")
    if kind and (kind != ["log"] or low <= 0.0 or high <= 0.0):
        raise ScenarioError(f"--over {text}: only :log may follow the count, and needs two positive ends")
    points = [_between(low, high, i / max(1, number - 1), bool(kind)) for i in range(number)]
    points[-1] = high
    return Axis(key, tuple(repr(point) for point in points), True, bool(kind))


def _between(low: float, high: float, share: float, logarithmic: bool) -> float:
    """The value at `share` of the way from `low` to `high`."""
    return low * (high / low) ** share if logarithmic else low + (high - low) * share


def grid(axes: Sequence[Axis]) -> list[tuple[str, ...]]:
    """Every combination of the axes' values, the last axis fastest."""
    return list(product(*(axis.values for axis in axes)))


def random_sample(axes: Sequence[Axis], runs: int, seed: int) -> list[tuple[str, ...]]:
    """`runs` combinations, each from a random stream of its own, so that more runs leave the first ones as they are."""
    return [tuple(axis.sample(Random(f"{seed}:sweep:{run}:{axis.key}")) for axis in axes) for run in range(runs)]


def apply(scenario: Scenario, axes: Sequence[Axis], values: Sequence[str]) -> None:
    """Set the axes' keys to `values`; whole-number keys take the nearest.

    Raises:
        ScenarioError: no such key, or an invalid value.
    """
    for axis, value in zip(axes, values, strict=True):
        if axis.key.startswith(_PARAMETER):
            scenario.set_text(f"{axis.key.removeprefix(_PARAMETER)}={value}", "--param")
        else:
            scenario.set_text(f"{axis.key}={value}", "--set")
