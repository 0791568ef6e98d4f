"""What can be wrong with a stream of samples: each is a function from the true samples to those that arrive.

`fault(truth, tick, past)` gets the true sample of now, the ticks since the fault began, and the true samples since
then, oldest first; it returns what arrives, or None.
"""

import math
from collections.abc import Callable

from documented_samples import WRAP

from sim_bridge.equipment.sensors import Sample

Fault = Callable[[Sample, int, list[Sample]], Sample | None]
FIELDS = ("time", "azimuth", "elevation", "distance", "course", "heading", "airspeed", "tether_force", "steering",
          "valid")
MALFORMED: tuple[tuple[int, float], ...] = (
    (1, math.nan), (1, 3.3), (2, -1.6), (2, math.inf), (3, 1e-30), (3, 0.0), (3, 2e4), (3, math.nan), (4, -2e6),
    (5, math.inf), (6, -1.0), (6, 1e9), (6, math.nan), (7, 1e7), (8, math.nan))


def changed(sample: Sample, **fields: float) -> Sample:
    """The sample with some of its fields, by name, in other values; its time stays within the clock's range."""
    values = dict(zip(FIELDS, sample, strict=True)) | fields
    values["time"] = int(values["time"]) % WRAP
    return tuple(values.values())  # type: ignore[return-value]


def moved(sample: Sample, angle: float) -> Sample:
    """The sample with its azimuth moved by `angle` [rad], within what is in range."""
    return changed(sample, azimuth=math.remainder(sample[1] + angle, 2.0 * math.pi))


def _late(ticks: int) -> Fault:
    return lambda truth, tick, past: past[tick - ticks] if tick >= ticks else None


def _at_times(every: int, disturb: Callable[[Sample], Sample | None]) -> Fault:
    return lambda truth, tick, past: disturb(truth) if tick % every == every - 1 else truth


def _shifted(offset_us: int) -> Fault:
    return lambda truth, tick, past: changed(truth, time=truth[0] + offset_us)


def _malformed(which: tuple[int, float]) -> Callable[[Sample], Sample]:
    index, value = which
    return lambda truth: (*truth[:index], value, *truth[index + 1 :])  # type: ignore[return-value]


FAULTS: dict[str, Fault] = {
    "missing": lambda truth, tick, past: None,
    "one in four": lambda truth, tick, past: None if tick % 4 else truth,
    "late by 5 ticks": _late(5),
    "late by 20 ticks": _late(20),
    "repeated": lambda truth, tick, past: past[0],
    "each repeated once": lambda truth, tick, past: past[tick - tick % 2],
    "stamp stands still": lambda truth, tick, past: changed(truth, time=past[0][0]),
    "stamp goes back": lambda truth, tick, past: changed(truth, time=past[0][0] - 20_000 * tick),
    "values stand still": lambda truth, tick, past: changed(past[0], time=truth[0]),
    "jump in every tick": lambda truth, tick, past: moved(truth, 1.0 + 2.4 * tick),
    "jumps add up": lambda truth, tick, past: moved(truth, 1.0 * (tick + 1)),
    "jumps to and fro": lambda truth, tick, past: moved(truth, 1.0 if tick % 2 else 0.0),
    "an outlier now and then": _at_times(7, lambda truth: moved(truth, 0.8)),
    "two places in turn, slowly": lambda truth, tick, past: moved(truth, 1.0 if tick // 10 % 2 == 0 else 0.0),
    "late copies": lambda truth, tick, past: past[-4] if tick % 3 == 2 and tick > 4 else truth,
    "stamps from the near future": _at_times(9, lambda truth: changed(truth, time=truth[0] + 100_000)),
    "stamps from the far future": _at_times(20, lambda truth: changed(truth, time=truth[0] + 30_000_000)),
    "all from the far future": _shifted(30_000_000),
    "all from the past": _shifted(-3_000_000),
    "stamps run fast": lambda truth, tick, past: changed(truth, time=past[0][0] + 400_000 * tick),
    "no azimuth": _at_times(2, lambda truth: changed(truth, valid=truth[9] & ~1)),
    **{f"malformed {which[0]} {which[1]:g}": _at_times(1 + index % 3, _malformed(which))
       for index, which in enumerate(MALFORMED)},
}


class Stream:
    """The true samples of a kite, and for a while another stream in their place."""

    def __init__(self) -> None:
        self._fault: Fault | None = None
        self._past: list[Sample] = []
        self._left = 0

    def disturb(self, name: str, ticks: int) -> None:
        """From now on, and for so many ticks, the samples are as FAULTS has it under `name`."""
        self._fault, self._past, self._left = FAULTS[name], [], ticks

    def arriving(self, truth: Sample) -> Sample | None:
        """What arrives in this tick."""
        if not self._left or self._fault is None:
            return truth
        self._left -= 1
        self._past.append(truth)
        return self._fault(truth, len(self._past) - 1, self._past)
