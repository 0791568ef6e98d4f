"""From samples to the kite's state: what is dropped changes nothing, and the turning angle is the kite's."""

import math
import random
from collections.abc import Callable

import numpy as np
import pytest
from firmware_bench import AIRSPEED, COURSE, DISTANCE, EVERYTHING, HEADING, NAMES, POSITION, sample

from firmware_py.estimation.estimator import Estimator
from kite_analysis.figure_eight import turning_angle
from protocol.parameter_table import load_parameters

WRAP_US = 1 << 30
PLAIN = ("azimuth", "elevation", "distance", "course", "heading", "airspeed", "tether_force", "steering", "speed",
         "valid", "sample_time", "interval", "coasting")


class Clocked(Estimator):
    """An estimator for which time passes as its samples arrive [us, wrapped]."""

    def __init__(self) -> None:
        super().__init__()
        self._now = 0

    def take_at(self, taken: tuple, now: int, asked: float) -> bool:
        self.stale_at(now)
        return self.take(taken, asked, 0.25)

    def stale_at(self, now: int) -> bool:
        elapsed_us, self._now = (now - self._now) % WRAP_US, now
        return self.wait(elapsed_us)


def estimator(**changed: float) -> Clocked:
    """An estimator with these parameters, the others at their default."""
    assert set(changed) <= set(NAMES)
    made = Clocked()
    made.config.load([changed.get(name, entry.default) for name, entry in load_parameters().items()])
    return made


def state(kite: Clocked) -> tuple:
    """All that others read of it."""
    frame = kite.frame
    return (*(getattr(kite, name) for name in PLAIN), frame.x, frame.y, frame.z, frame.e1x, frame.e1y, frame.e2x)


def flying(rate_us: int = 20_000) -> tuple[Clocked, int]:
    """An estimator that has seen a kite fly for half a second, and the time of its last sample."""
    kite = estimator()
    for tick in range(25):
        assert kite.take_at(sample(tick * rate_us, azimuth=0.1 + 0.004 * tick), tick * rate_us, 0.0)
    return kite, 24 * rate_us


def difference(first: float, second: float) -> float:
    return math.remainder(first - second, 2.0 * math.pi)


BROKEN = {
    "no azimuth": {"valid": EVERYTHING & ~1},
    "no elevation": {"valid": EVERYTHING & ~2},
    "nothing measured": {"valid": 0},
    "azimuth past the back": {"azimuth": 3.21},
    "elevation past the zenith": {"elevation": 1.571},
    "elevation past the nadir": {"elevation": -1.571},
    "no distance at all": {"distance": 0.0},
    "distance behind": {"distance": -1.0},
    "airspeed from behind": {"airspeed": -0.001},
    "far too long": {"distance": 1.0e6},
    "an impossible jump in azimuth": {"azimuth": 0.2 + 0.06},
    "an impossible jump in elevation": {"elevation": 0.7 - 0.05},
    "the other side of the sky": {"azimuth": 3.1},
}
for field in ("azimuth", "elevation", "distance", "course", "heading", "airspeed", "tether_force", "steering"):
    for number in (math.nan, math.inf, -math.inf, 3e38, -3e38):
        BROKEN[f"{field} {number}"] = {field: number}


# After these the kite is said to have been elsewhere, and the next sample, which is right, is from too far away.
_ELSEWHERE = ("an impossible jump in elevation", "the other side of the sky")


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_sample_is_dropped_counted_and_changes_nothing(name):
    fault = BROKEN[name]
    kite, now = flying()
    before = state(kite)
    fields = {"azimuth": 0.2, **fault}
    assert not kite.take_at(sample(now + 20_000, **fields), now + 20_000, 0.3)
    assert kite.dropped == 1
    assert state(kite) == before
    assert kite.take_at(sample(now + 40_000, azimuth=0.204), now + 40_000, 0.3) == (name not in _ELSEWHERE)
    assert kite.take_at(sample(now + 60_000, azimuth=0.208), now + 60_000, 0.3)
    assert kite.interval == pytest.approx(0.06 if name in _ELSEWHERE else 0.02)
    assert (kite.azimuth, kite.dropped) == (0.208, 1 + (name in _ELSEWHERE))


LIMITS = [
    ("azimuth", -3.2, 3.2), ("elevation", -1.5708, 1.5708), ("distance", 1.0, 10_000.0), ("airspeed", 0.0, 200.0),
    *((field, math.nextafter(-1e6, 0.0), math.nextafter(1e6, 0.0))
      for field in ("course", "heading", "tether_force", "steering")),
]


@pytest.mark.parametrize(("field", "least", "greatest"), LIMITS)
def test_each_limit_of_a_sample_and_one_step_to_either_side(field, least, greatest):
    for value, taken in (
            (least, True), (math.nextafter(least, -math.inf), False), (math.nextafter(least, math.inf), True),
            (greatest, True), (math.nextafter(greatest, math.inf), False), (math.nextafter(greatest, 0.0), True)):
        kite = estimator()
        assert kite.take_at(sample(0, **{field: value}), 0, 0.0) is taken, value  # type: ignore[arg-type]
        assert kite.has_heard() is taken
        assert kite.is_stale() is not taken


@pytest.mark.parametrize(("span_us", "taken"), [
    (-1, False), (0, False), (1, True), (5_020_000, True), (5_020_001, False), (WRAP_US // 2 - 1, False)])
def test_a_stamp_may_run_ahead_of_the_firmwares_clock_by_five_seconds(span_us, taken):
    """A link that catches up brings stamps closer together than they arrive, not further apart."""
    kite, now = flying()
    there = sample((now + span_us) % WRAP_US, kite.azimuth)
    assert kite.take_at(there, now + 20_000, 0.0) is taken


@pytest.mark.parametrize(("apart_us", "believed"), [(500_000, False), (500_001, True)])
def test_after_a_gap_a_sample_must_follow_from_the_one_before_it_within_stale_time(apart_us, believed):
    """Two samples from two places that no kite flies between: news only if the first is old enough to forget."""
    kite, now = flying()
    later = now + 2_000_000
    assert kite.stale_at(later)
    broken = sample(later, azimuth=-1.0, airspeed=-1.0)
    assert not kite.take_at(broken, later, 0.0)  # out of range is not looked at
    assert kite.take_at(sample(later + 20_000, azimuth=-1.0), later + 20_000, 0.0)
    assert not kite.take_at(sample(later + 40_000, azimuth=1.0), later + 40_000, 0.0)
    assert kite.stale_at(later + 520_001)
    at = later + 40_000 + apart_us
    assert kite.take_at(sample(at, azimuth=-1.0), at, 0.0) is believed


@pytest.mark.parametrize("back_us", [0, 1, 20_000, 200_000, 60_000_000])
def test_a_sample_from_the_past_or_a_second_time_is_dropped(back_us):
    kite, now = flying()
    before = state(kite)
    assert not kite.take_at(sample((now - back_us) % WRAP_US, azimuth=-1.0), now + 20_000, 0.0)
    assert (kite.dropped, state(kite)) == (1, before)
    assert kite.take_at(sample(now + 1, azimuth=0.196), now + 20_000, 0.0)


@pytest.mark.parametrize("later_us", [1, 2, 20_000])
def test_a_sample_from_elsewhere_is_what_the_next_one_is_held_against(later_us):
    """So no stream of jumps is believed one by one; one with an old stamp is no sample at all."""
    kite, now = flying()
    assert not kite.take_at(sample(now + later_us, azimuth=-1.0), now + 20_000, 0.0)
    assert not kite.take_at(sample(now + 40_000, azimuth=0.2), now + 40_000, 0.0)
    assert kite.take_at(sample(now + 60_000, azimuth=0.204), now + 60_000, 0.0)
    assert kite.dropped == 2


def test_what_is_not_measured_may_be_anything_and_is_stood_in_for():
    kite = estimator(LINE_LENGTH=250.0, AIRSPEED_NOM=17.0)
    nothing = dict.fromkeys(("distance", "course", "heading", "airspeed", "tether_force", "steering"), math.nan)
    for tick in range(40):
        assert kite.take_at(sample(tick * 20_000, azimuth=0.004 * tick, valid=POSITION, **nothing), tick * 20_000, 0.25)
    assert (kite.distance, kite.airspeed, kite.tether_force, kite.steering) == (250.0, 17.0, 0.0, 0.25)
    assert kite.heading == kite.course == pytest.approx(-math.pi / 2, abs=0.1)  # towards +y
    assert kite.speed == pytest.approx(250.0 * 0.2 * math.cos(0.7), rel=1e-3)
    assert kite.valid == POSITION


def away(kite: Clocked, way: float, bearing: float) -> dict[str, float]:
    """Where a great circle ends that is `way` [rad] long and leaves at `bearing`, from up towards +azimuth."""
    start = kite.elevation
    elevation = math.asin(math.sin(start) * math.cos(way) + math.cos(start) * math.sin(way) * math.cos(bearing))
    turned = math.atan2(math.sin(bearing) * math.sin(way) * math.cos(start),
                        math.cos(way) - math.sin(start) * math.sin(elevation))
    return {"azimuth": kite.azimuth + turned, "elevation": elevation}


@pytest.mark.parametrize("bearing", [0.0, 0.8, 1.57, 2.5, math.pi, -2.0, -1.0])
def test_a_jump_is_judged_by_the_time_that_it_had(bearing):
    """120 deg/s and 3 mrad of noise: after 20 ms 0.0449 rad, whatever the direction; after 100 ms 0.2124 rad."""
    for interval_us, furthest in ((20_000, math.radians(2.4) + 0.003), (100_000, math.radians(12.0) + 0.003)):
        for jump, taken in ((furthest * 0.999, True), (furthest * 1.001, False)):
            kite, now = flying()
            there = sample(now + interval_us, **away(kite, jump, bearing))  # type: ignore[arg-type]
            assert kite.take_at(there, now + interval_us, 0.0) is taken


@pytest.mark.parametrize(("azimuth", "elevation"), [(-0.196, 0.7), (0.196, -0.7), (-0.196, -0.7)])
def test_a_jump_to_the_mirrored_place_is_a_jump(azimuth, elevation):
    kite, now = flying()
    assert not kite.take_at(sample(now + 20_000, azimuth=azimuth, elevation=elevation), now + 20_000, 0.0)


def test_a_jump_is_measured_across_the_sky_and_not_in_azimuth():
    """Near the zenith half a turn of azimuth is a small step, and azimuth may go round the back."""
    kite = estimator()
    assert kite.take_at(sample(0, azimuth=0.0, elevation=1.56), 0, 0.0)
    assert kite.take_at(sample(20_000, azimuth=2.5, elevation=1.56), 20_000, 0.0)
    kite = estimator()
    assert kite.take_at(sample(0, azimuth=3.14, elevation=0.3), 0, 0.0)
    assert kite.take_at(sample(20_000, azimuth=-3.14, elevation=0.3), 20_000, 0.0)


def test_the_clock_may_wrap_in_flight():
    start = WRAP_US - 250_000
    wrapped, plain = estimator(), estimator()
    for tick in range(25):
        for kite, offset in ((wrapped, start), (plain, 0)):
            time_us = (offset + tick * 20_000) % WRAP_US
            there = sample(time_us, azimuth=0.1 + 0.004 * tick, elevation=0.7 + 0.002 * tick, valid=POSITION)
            assert kite.take_at(there, time_us, 0.0)
            assert not kite.stale_at((time_us + 400_000) % WRAP_US)
    assert wrapped.sample_time == 24 * 20_000 - 250_000
    assert wrapped.course == plain.course
    assert wrapped.speed == plain.speed


def test_after_a_gap_a_sample_from_anywhere_is_taken_and_nothing_is_made_of_the_way_there():
    kite, now = flying()
    assert not kite.stale_at(now + 500_000)
    assert kite.stale_at(now + 500_001)
    later = now + 600_000
    there = sample(later, azimuth=-1.0, elevation=0.3, course=2.0)
    assert kite.take_at(there, later, 0.0)  # its clock may be a new one
    assert (kite.azimuth, kite.interval, kite.coasting) == (-1.0, 0.0, False)
    assert not kite.stale_at(later)
    for tick in range(1, 20):
        time_us = later + tick * 20_000
        assert kite.take_at(sample(time_us, azimuth=-1.0 + 0.004 * tick, elevation=0.3, valid=POSITION), time_us, 0.0)
    assert difference(kite.course, -math.pi / 2) == pytest.approx(0.0, abs=0.05)
    assert kite.speed == pytest.approx(100.0 * 0.2 * math.cos(0.3), rel=1e-3)


def test_a_sensor_that_starts_anew_is_believed_once_the_old_samples_are_stale():
    kite, now = flying()
    dropped = 0
    for tick in range(1, 40):  # its clock begins at 0 again
        time_us = now + tick * 20_000
        dropped += not kite.take_at(sample(tick), time_us, 0.0)
    assert dropped == 25  # half a second
    assert kite.sample_time == 39


def test_stamps_that_go_back_are_not_believed_though_the_last_one_accepted_is_stale():
    kite, now = flying()
    for tick in range(1, 100):
        assert not kite.take_at(sample(now - tick * 20_000), now + tick * 20_000, 0.0)
    there = now + 100 * 20_000
    assert kite.take_at(sample(there), there, 0.0)


def test_silence_stays_silence_when_the_clock_wraps_round():
    """2^29 us are nine minutes: a difference of times is then negative, and must not look like a fresh sample."""
    kite, now = flying()
    for second in range(1, 1200):
        assert kite.stale_at((now + second * 1_000_000) % WRAP_US)
    assert kite.take_at(sample(5), 5, 0.0)
    assert not kite.stale_at(5)


Path = Callable[[float], np.ndarray]


def circle(pole: tuple[float, float, float], radius: float, speed: float) -> Path:
    """Unit position (3,) over time, counter-clockwise about `pole` seen from outside, at `speed` [rad/s]."""
    axis = np.array(pole) / np.linalg.norm(pole)
    first = np.cross(axis, [0.0, 0.0, 1.0])
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)

    def position(time_s: float) -> np.ndarray:
        turned = speed * time_s / math.sin(radius)
        return math.cos(radius) * axis + math.sin(radius) * (math.cos(turned) * first + math.sin(turned) * second)

    return position


def true_course(path: Path, time_s: float) -> float:
    return float(turning_angle(path(time_s), path(time_s + 1e-5) - path(time_s - 1e-5)))


def fly(kite: Clocked, path: Path, rate_hz: float, seconds: float, noise: float = 0.0, valid: int = POSITION,
        wrong: float = 0.0) -> np.ndarray:
    """Errors (n,) of the course [rad] over a flight along `path`; measured course and heading are off by `wrong`."""
    dice = random.Random(3)
    errors = []
    for tick in range(round(seconds * rate_hz)):
        time_s = tick / rate_hz
        time_us = round(time_s * 1e6)
        x, y, z = path(time_s)
        azimuth, elevation = math.atan2(y, x) + dice.gauss(0.0, noise), math.asin(z) + dice.gauss(0.0, noise)
        course = true_course(path, time_s)
        measured = sample(time_us, azimuth, elevation, course=course + wrong, heading=course + 2 * wrong, valid=valid)
        assert kite.take_at(measured, time_us, 0.0)
        errors.append(difference(kite.course, course))
    return np.array(errors)


GREAT_CIRCLES = [circle(pole, math.pi / 2, 0.2) for pole in ((0.0, 1.0, 1.0), (0.1, -1.0, 1.0), (-0.7, 0.2, 1.0))]
SMALL_CIRCLES = [circle((1.0, 0.2, 0.7), 0.15, speed) for speed in (0.1, 0.2)]


@pytest.mark.parametrize("rate_hz", [10.0, 50.0])
@pytest.mark.parametrize("path", GREAT_CIRCLES)
def test_course_from_positions_on_great_circles(path, rate_hz):
    """What is left on a straight flight is meridian convergence."""
    errors = fly(estimator(), path, rate_hz, 6.0)
    assert np.abs(errors[round(rate_hz) :]).max() < 0.005


@pytest.mark.parametrize("rate_hz", [10.0, 50.0])
@pytest.mark.parametrize("path", SMALL_CIRCLES)
def test_course_from_positions_on_small_circles(path, rate_hz):
    """Turning by up to 1.3 rad/s: without the correction for its span the chord would be late by 0.17 rad."""
    errors = fly(estimator(), path, rate_hz, 8.0)
    settled = np.abs(errors[round(2 * rate_hz) :])
    assert settled.max() < 0.06


@pytest.mark.parametrize("rate_hz", [10.0, 50.0])
@pytest.mark.parametrize("path", [GREAT_CIRCLES[0], SMALL_CIRCLES[1]])
def test_course_from_noisy_positions(path, rate_hz):
    """0.5 mrad on each angle, over chords of 50 mrad: 15 mrad of the course and as much again for its turning."""
    errors = fly(estimator(), path, rate_hz, 12.0, noise=0.5e-3)[round(2 * rate_hz) :]
    assert np.sqrt(np.mean(errors**2)) < 0.05
    assert np.abs(errors).max() < 0.2
    unsmoothed = fly(estimator(COURSE_WINDOW=0.0), path, 50.0, 12.0, noise=0.5e-3)[100:]
    assert np.sqrt(np.mean(unsmoothed**2)) > 0.1  # so the window is worth its while


def test_the_source_of_the_course_is_the_parameters_choice():
    """Measured course and heading are off by 0.3 and 0.6 rad here, which tells the sources apart."""
    path = GREAT_CIRCLES[0]
    measured = POSITION | COURSE | HEADING | DISTANCE
    for source, valid, off in (
        (0.0, measured, 0.3), (1.0, measured, 0.3), (2.0, measured, 0.0), (3.0, measured, 0.6),
        (0.0, POSITION, 0.0), (1.0, POSITION | HEADING, 0.0), (3.0, POSITION | COURSE, 0.0)):
        kite = estimator(COURSE_SOURCE=source)
        errors = fly(kite, path, 50.0, 3.0, valid=valid, wrong=0.3)
        assert errors[50:] == pytest.approx(off, abs=0.01), (source, valid)
        assert kite.speed == pytest.approx(20.0, rel=1e-3)


def test_a_change_of_source_in_flight_is_smooth():
    """The chord is followed all the time, so that positions can take over from a heading at once."""
    kite = estimator(COURSE_SOURCE=3.0)
    path = SMALL_CIRCLES[0]
    fly(kite, path, 50.0, 4.0, valid=POSITION | HEADING)
    kite.config.course_source = 2.0
    x, y, z = path(4.0)
    assert kite.take_at(sample(4_000_000, math.atan2(y, x), math.asin(z), valid=POSITION), 4_000_000, 0.0)
    assert difference(kite.course, true_course(path, 4.0)) == pytest.approx(0.0, abs=0.03)


def test_too_slow_to_see_a_course_the_turning_rate_law_carries_it_on():
    """A kite at rest, steering 0.1: it turns by K Va u = 0.5 rad/s, over the wrap of the angle too."""
    kite = estimator(COURSE_SOURCE=0.0, SPEED_MIN=1.0)
    valid = POSITION | COURSE | AIRSPEED
    kite.take_at(sample(0, course=3.0, valid=valid), 0, 0.1)
    assert (kite.course, kite.coasting) == (3.0, False)
    for tick in range(1, 101):  # the steering asked stands in for the one that is not measured
        kite.take_at(sample(tick * 20_000, course=1.0, valid=valid), tick * 20_000, 0.1)
        assert kite.coasting
        assert difference(kite.course, 3.0 + 0.5 * 0.02 * tick) == pytest.approx(0.0, abs=1e-9)
        assert -math.pi < kite.course <= math.pi
    assert kite.heading == kite.course

    for tick in range(101, 140):  # fast enough again
        kite.take_at(sample(tick * 20_000, 0.1 + 0.004 * (tick - 100), course=1.0, valid=valid), tick * 20_000, 0.1)
    assert not kite.coasting
    assert kite.course == 1.0


def test_a_kite_that_stands_still_keeps_its_course_even_without_a_least_speed():
    kite = estimator(SPEED_MIN=0.0, COURSE_WINDOW=0.0)
    for tick in range(60):
        azimuth = 0.004 * min(tick, 30)
        kite.take_at(sample(tick * 20_000, azimuth, valid=POSITION), tick * 20_000, 0.0)
        if tick > 1:
            assert kite.course == pytest.approx(-math.pi / 2, abs=0.01)
