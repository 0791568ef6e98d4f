"""What the errors of a measured quantity are made of: its past, noise that wanders, dropouts."""

from math import exp, inf, remainder, sqrt, tau
from random import Random
from typing import Final

_NEVER_READ: Final = -inf


class Past:
    """What a quantity was `lag_s` ago: linear between the ticks, of a `circular` one the short way round.

    Before the first tick it was what it was then.
    """

    def __init__(self, lag_s: float, circular: bool) -> None:
        self._lag_s = lag_s
        self._circular = circular
        self._times: list[float] = []  # the first two enclose the time asked for
        self._values: list[float] = []

    def add(self, time_s: float, value: float) -> None:
        """Take the value at `time_s`, later than all before."""
        self._times.append(time_s)
        self._values.append(value)
        while len(self._times) > 1 and self._times[1] <= time_s - self._lag_s:
            self._times.pop(0)
            self._values.pop(0)

    def value(self) -> float:
        """What the quantity was `lag_s` before the newest time."""
        first_s = self._times[0]
        since_s = self._times[-1] - self._lag_s - first_s
        first = self._values[0]
        if since_s <= 0.0 or len(self._times) == 1:
            return first
        change = self._values[1] - first
        if self._circular:
            change = remainder(change, tau)
        return first + change * since_s / (self._times[1] - first_s)


class Wander:
    """First-order Gauss-Markov noise, stationary from the start, discretised exactly for any times."""

    def __init__(self, deviation: float, correlation_s: float, seed: str) -> None:
        self._deviation = deviation
        self._correlation_s = correlation_s
        self._random = Random(seed)
        self._value = 0.0  # of unit variance
        self._time_s = _NEVER_READ

    def at(self, time_s: float) -> float:
        """The noise at `time_s`, not before the time asked for last."""
        keep = exp((self._time_s - time_s) / self._correlation_s)
        self._value = keep * self._value + sqrt(1.0 - keep * keep) * self._random.gauss(0.0, 1.0)
        self._time_s = time_s
        return self._deviation * self._value


class Dropouts:
    """Gilbert-Elliott in continuous time: a `fraction` of the time is lost, in dropouts of `length_s` in the mean.

    It is discretised exactly for any times, stationary from the start. With length 0, samples are lost independently.
    """

    def __init__(self, fraction: float, length_s: float, seed: str) -> None:
        self._fraction = fraction
        self._forget_s = length_s * (1.0 - fraction)  # correlation time
        self._random = Random(seed)
        self._missing = False
        self._time_s = _NEVER_READ

    def missing_at(self, time_s: float) -> bool:
        """True if there is nothing at `time_s`, not before the time asked for last."""
        if not self._fraction:
            return False
        keep = exp((self._time_s - time_s) / self._forget_s) if self._forget_s else 0.0
        before = 1.0 if self._missing else 0.0
        self._missing = self._random.random() < self._fraction + keep * (before - self._fraction)
        self._time_s = time_s
        return self._missing
