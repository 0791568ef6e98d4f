"""docs/modes.md, "When samples are fresh", as an oracle: written from that page, not from the firmware.

Times are in microseconds; `now` never wraps, the samples' stamps do.
"""

import math
from typing import NamedTuple

from sim_bridge.equipment.sensors import Sample

SECOND = 1_000_000
WRAP = 1 << 30
FRESH_US = SECOND // 2  # samples must have been accepted for this long
AHEAD_US = 5 * SECOND  # a stamp may be so much further ahead than the clock has moved
SLACK = 0.003  # [rad]
LIMITS = (3.2, 1.5708, None, 1e6, 1e6, None, 1e6, 1e6)  # of the quantities either way, in the order of their valid bits
DISTANCE_M, AIRSPEED_M_S = (1.0, 1e4), (0.0, 200.0)
POSITION = 0b11


class Place(NamedTuple):
    """Where and when the kite was, as a sample told; `arrival` is by the firmware's clock, `stamp` by the sample's."""

    arrival: int
    stamp: int
    azimuth: float
    elevation: float
    course: float


class DocumentedSamples:
    """Which samples are accepted, and for how long. `stale_time` [us] and `jump_rate` [rad/s] are the parameters."""

    def __init__(self) -> None:
        self.last: Place | None = None  # the last one accepted
        self.before: Place | None = None  # the one before, accepted or not
        self.accepted_since: int | None = None  # with no gap above STALE_TIME
        self.stale_time = 0
        self.jump_rate = 0.0

    def is_old(self, now: int) -> bool:
        """Nothing was accepted for STALE_TIME. Asked before a tick's own sample is looked at."""
        return self.last is None or now - self.last.arrival > self.stale_time

    def take(self, now: int, sample: Sample | None) -> None:
        """A tick, with the sample that it brings."""
        old = self.is_old(now)
        if old:
            self.accepted_since = None
        if sample is None or not is_well_formed(sample):
            return
        place = as_place(now, sample)
        if self._starts_anew(place) if old else self._goes_on(place):
            self.last = place
            if self.accepted_since is None:
                self.accepted_since = now
        self.before = place

    def are_fresh_again(self) -> bool:
        """A sample was accepted half a second after another one, with no gap."""
        return self.accepted_since is not None and self.last is not None and (
            self.last.arrival - self.accepted_since >= FRESH_US)

    def is_close_call(self, now: int, sample: Sample) -> bool:
        """A sample so near to how far a kite can fly that rounding decides: not one to judge a firmware by."""
        if not is_well_formed(sample):
            return False
        place = as_place(now, sample)
        return any(abs(distance(known, place) - self._reach(known, place)) < 1e-5
                   for known in (self.last, self.before) if known)

    def _goes_on(self, place: Place) -> bool:
        assert self.last is not None and self.before is not None
        if later(self.before.stamp, self.last.stamp) <= 0:
            return self._follows(self.last, place)
        return self._follows(self.last, place) and self._follows(self.before, place)

    def _starts_anew(self, place: Place) -> bool:
        before = self.before
        if before is None:
            return True
        if place.arrival - before.arrival <= self.stale_time:
            return self._follows(before, place)
        return place.stamp != before.stamp

    def _follows(self, known: Place, place: Place) -> bool:
        """Its stamp is later, no further ahead than the clock has moved plus 5 s, and the kite can have come there."""
        ahead = later(place.stamp, known.stamp)
        return (0 < ahead <= place.arrival - known.arrival + AHEAD_US
                and distance(known, place) <= self._reach(known, place))

    def _reach(self, known: Place, place: Place) -> float:
        return self.jump_rate * later(place.stamp, known.stamp) / SECOND + SLACK


def as_place(now: int, sample: Sample) -> Place:
    """What a sample that arrives `now` tells."""
    return Place(now, sample[0], sample[1], sample[2], sample[4])


def is_well_formed(sample: Sample) -> bool:
    """Azimuth and elevation are there, and all that is marked valid is finite and in range."""
    valid = sample[9]
    if valid & POSITION != POSITION:
        return False
    for bit, limit in enumerate(LIMITS):
        least, greatest = (-limit, limit) if limit else DISTANCE_M if bit == 2 else AIRSPEED_M_S
        if valid >> bit & 1 and not least <= sample[1 + bit] <= greatest:
            return False
    return True


def later(stamp: int, other: int) -> int:
    """How much later a stamp is than another [us]; negative if it is earlier."""
    return (stamp - other + WRAP // 2) % WRAP - WRAP // 2


def distance(one: Place, other: Place) -> float:
    """Angle between two places [rad]."""
    a, b = unit(one), unit(other)
    cross = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    return math.atan2(math.hypot(*cross), sum(x * y for x, y in zip(a, b, strict=True)))


def unit(place: Place) -> tuple[float, float, float]:
    """Unit position."""
    level = math.cos(place.elevation)
    return level * math.cos(place.azimuth), level * math.sin(place.azimuth), math.sin(place.elevation)
