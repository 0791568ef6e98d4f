"""Jitter and loss as a delay: the mean age, and the gain limit of a loop that is flown over the emulated links."""

import math

import pytest

from kite_analysis.delay.characteristic_equation import Loop
from kite_analysis.delay.effective_delay import Path, effective_delay
from kite_analysis.delay.inner_loop import loop_delay
from kite_analysis.delay.whole_loop import gain_limit
from kite_analysis.delay.whole_periods import split
from sim_bridge.links.emulation import LinkDirection
from sim_bridge.links.link_settings import LinkSettings

HZ, SPEED, OUTER_L = 50.0, 0.45, 3.0
PERIOD = 1.0 / HZ


class FlownLoop:
    """Small errors on a great circle, exactly between events: d' = -w c, c' = w d + the steering that is held."""

    def __init__(self, delay_s: float, gain: float, seed: int = 1, **link: float):
        down, up = (LinkSettings(delay_s=part, **link) for part in split(delay_s, 1.0 / HZ))
        self._down, self._up = LinkDirection(down, f"{seed}:down"), LinkDirection(up, f"{seed}:up")
        self._gain = gain
        self.cross_track, self.course, self._time = 1e-3, 0.0, 0.0
        self._seen, self._held = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)  # sample; time sent, turning rate, its sample's time
        self.ages: list[tuple[float, float]] = []  # how long [s], mean age [s]

    def fly(self, duration_s: float) -> None:
        for _ in range(round(duration_s * HZ)):
            now = self._time
            self._down.send(now, (now, self.cross_track, self.course), 1)
            self._seen = max([self._seen, *(parcel.item for parcel in self._down.due(now))], key=lambda item: item[0])
            rate = self._gain * (OUTER_L * self._seen[1] - self._seen[2])
            self._up.send(now, (now, rate, self._seen[0]), 1)
            for parcel in self._up.due(now + PERIOD):
                self._advance(max(parcel.time_s, self._time))
                if parcel.item[0] >= self._held[0]:
                    self._held = parcel.item
            self._advance(now + PERIOD)

    def growth(self) -> float:
        """Mean rate at which errors grow [1/s], over five minutes or until they are beyond what a float holds well."""
        self.fly(10.0)
        start, first = self._time, math.hypot(self.cross_track, self.course)
        growth = 0.0
        while abs(growth) < 300.0 and self._time < start + 300.0:
            self.fly(5.0)
            growth = math.log(math.hypot(self.cross_track, self.course) / first)
        return growth / (self._time - start)

    def mean_age(self) -> tuple[float, float]:
        """Mean and standard deviation [s] of the age of what steers, over ten minutes, as EffectiveDelay counts it."""
        self.fly(600.0)
        steady = self.ages[1000:]
        total = math.fsum(duration for duration, _ in steady)
        mean = math.fsum(duration * age for duration, age in steady) / total
        square = math.fsum(duration * (age**2 + duration**2 / 12.0) for duration, age in steady) / total
        return mean - PERIOD / 2.0, math.sqrt(max(0.0, square - mean**2 - PERIOD**2 / 12.0))

    def _advance(self, until: float) -> None:
        duration, rate = until - self._time, self._held[1]
        if duration <= 0.0:
            return
        self.ages.append((duration, 0.5 * (self._time + until) - self._held[2]))
        cosine, sine = math.cos(SPEED * duration), math.sin(SPEED * duration)
        offset = self.cross_track + rate / SPEED
        self.cross_track = offset * cosine - self.course * sine - rate / SPEED
        self.course = offset * sine + self.course * cosine
        self._time = until


def predicted(delay_s: float, jitter_s: float = 0.0, loss: float = 0.0, loss_burst: float = 0.0):
    down, up = (Path(part, jitter_s, loss, loss_burst) for part in split(delay_s, 1.0 / HZ))
    return effective_delay(down, up, HZ)


LINKS = [
    (0.1, {"loss": 0.1}), (0.2, {"loss": 0.3}), (0.4, {"loss": 0.6}), (0.2, {"loss": 0.1, "loss_burst": 5.0}),
    (0.2, {"jitter_s": 0.005}), (0.2, {"jitter_s": 0.05}), (0.4, {"jitter_s": 0.1}), (0.1, {"jitter_s": 0.05}),
    (0.2, {"jitter_s": 0.02, "loss": 0.1}), (0.4, {"jitter_s": 0.05, "loss": 0.2}),
]


@pytest.mark.parametrize(("delay_s", "link"), [*LINKS, (0.11, {"jitter_s": 0.1, "loss": 0.3, "loss_burst": 3.0}),
                                               (0.0, {"jitter_s": 0.03, "loss": 0.1})])
def test_the_mean_age_is_as_said(delay_s, link):
    effective = predicted(delay_s, **link)
    mean, scatter = FlownLoop(delay_s, gain=1.0, **link).mean_age()
    assert mean == pytest.approx(effective.delay_s, rel=0.02, abs=5e-4)
    assert scatter == pytest.approx(effective.scatter_s, rel=0.15, abs=1e-3)  # ten minutes have few bursts


@pytest.mark.parametrize(("delay_s", "link"), LINKS)
def test_the_limit_is_that_of_the_mean_age_on_the_safe_side(delay_s, link):
    """By bisection over flights of five minutes: above the prediction by about 1.2 (scatter / tau')^2, never below."""
    effective = predicted(delay_s, **link)
    sampled_s = loop_delay(effective.delay_s, HZ)
    limit = gain_limit(Loop(sampled_s, SPEED), OUTER_L)
    low, high = 0.9 * limit, 1.25 * limit
    assert FlownLoop(delay_s, low, **link).growth() < 0.0 < FlownLoop(delay_s, high, **link).growth()
    for _ in range(5):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if FlownLoop(delay_s, middle, **link).growth() < 0.0 else (low, middle)
    found = 0.5 * (low + high) / limit
    assert 0.98 < found < 1.02 + 1.5 * (effective.scatter_s / sampled_s) ** 2


def test_closed_forms():
    period = PERIOD
    for loss in (0.1, 0.5):
        assert predicted(0.2, loss=loss).delay_s == pytest.approx(0.2 + 2 * period * loss / (1 - loss))
        assert predicted(0.2, loss=loss, loss_burst=4.0).delay_s == pytest.approx(0.2 + 2 * period * loss * 4.0)
    just_late = effective_delay(Path(0.1, 0.001), Path(0.1), HZ)
    assert just_late.delay_s == pytest.approx(0.2 + period / 2)
    steering_only = effective_delay(Path(0.1), Path(0.1, period / 2), HZ)
    assert steering_only.delay_s == pytest.approx(0.2)
    assert effective_delay(Path(0.1), Path(0.1, 4 * period), HZ).delay_s < 0.2 - period
    assert predicted(0.2) == pytest.approx((0.2, 0.1, 0.1, 0.0), abs=1e-9)


def test_what_is_no_link_is_refused():
    for path, said in ((Path(-0.1), "delay of -0.1 s"), (Path(0, math.nan), "jitter of nan"), (Path(loss=1.0), "loss")):
        with pytest.raises(ValueError, match=said):
            effective_delay(path, Path(), HZ)
    with pytest.raises(ValueError, match="loop rate"):
        effective_delay(Path(), Path(), 0.0)
