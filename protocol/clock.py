"""The clock of the firmware and of its sensors: microseconds that wrap at 2^30, and how they are counted on."""

from collections.abc import Iterable
from typing import Any

WRAP_US = 1 << 30
_MOST_DELAY_S = 5.0  # a link does not delay by more


def difference_us(later_us: Any, earlier_us: Any) -> Any:
    """Time from `earlier_us` to `later_us` on a wrapping clock [us], from -2^29 to below 2^29; numbers or arrays."""
    return (later_us - earlier_us + WRAP_US // 2) % WRAP_US - WRAP_US // 2


class RunningClock:
    """Counts a wrapping clock on, from one reading to the next as they come, the first of which is 0.

    Where the clock and the times at which its readings came disagree by more than a link delays, its owner has started
    anew, or was silent for longer than a turn of the clock: there the latter count.
    """

    def __init__(self) -> None:
        self._elapsed_us = 0
        self._reading_us: int | None = None
        self._came_s = 0.0

    def elapsed_s(self, reading_us: int, came_s: float) -> float:
        """Time [s] since the first reading of this one [us], which came at `came_s` [s] by the receiver's clock."""
        if self._reading_us is not None:
            step_us, came_us = difference_us(reading_us, self._reading_us), round((came_s - self._came_s) * 1e6)
            self._elapsed_us += step_us if abs(step_us - came_us) < _MOST_DELAY_S * 1e6 else came_us
        self._reading_us, self._came_s = reading_us, came_s
        return self._elapsed_us * 1e-6


def counted_on(readings_us: Iterable[float], came_s: Iterable[float]) -> list[float]:
    """Seconds since the first of these readings [us], which came at `came_s` [s]; see RunningClock."""
    clock = RunningClock()
    return [clock.elapsed_s(int(reading_us), at_s) for reading_us, at_s in zip(readings_us, came_s, strict=True)]


def ages_s(now_us: Iterable[float], then_us: Iterable[float]) -> list[float]:
    """How much later each of `now_us` is than its `then_us` [s]: as near to 0 as can be at first, and without jumps.

    The two may be of different clocks, which drift apart.
    """
    ages, age_us = [], 0
    for now, then in zip(now_us, then_us, strict=True):
        age_us = nearest_us(int(now) - int(then), age_us)
        ages.append(age_us * 1e-6)
    return ages


def nearest_us(apart_us: int, expected_us: int) -> int:
    """The time nearest to `expected_us` that two readings can be apart, whose difference is `apart_us` [us]."""
    return expected_us + difference_us(apart_us, expected_us)
