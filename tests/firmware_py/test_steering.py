"""The inner loop: its law term by term, and the limits that nothing gets past."""

import math
from typing import Any

import pytest
from eights import gains, parameters
from hypothesis import example, given, settings
from hypothesis import strategies as st

from firmware_py.control.steering import Steering
from firmware_py.estimation.estimator import Estimator
from firmware_py.generated_enums import KITE_STATUS_AIRSPEED_FLOOR, KITE_STATUS_SATURATED, KITE_STATUS_SLEWED

PERIOD_S = 0.02
any_float32 = st.floats(width=32, allow_nan=False, allow_infinity=False)


class Loop(Steering):
    """The inner loop with K = 0.25 rad/m, P = 2 /s, no feed-forward, no limits; and what is `changed`."""

    def __init__(self, **changed: float):
        super().__init__()
        settings = {"TURN_K": 0.25, "INNER_P": 2.0, "FF_GAIN": 0.0, "AIRSPEED_MIN": 4.0, **changed}
        self.config.load(parameters(**settings))
        self.gains = gains(**settings)


def kite(**changed: Any) -> Estimator:
    """A kite at 0.8 rad of elevation, on a course of 0.5 rad with 20 m/s of apparent wind: K Va = 5 /s."""
    made = Estimator()
    for name, value in {"course": 0.5, "heading": 0.5, "airspeed": 20.0, "elevation": 0.8, **changed}.items():
        assert hasattr(made, name)
        setattr(made, name, value)
    made.frame.set(made.azimuth, made.elevation)
    return made


def followed(loop: Loop, target: float, rate: float = 0.0, **kite_fields: Any) -> float:
    loop.follow(target, rate, kite(**kite_fields), loop.gains, PERIOD_S)
    return loop.asked


def test_proportional_term():
    loop = Loop()
    assert followed(loop, 0.7) == pytest.approx(2.0 * 0.2 / 5.0)
    assert loop.error == pytest.approx(0.2)
    assert loop.status == 0
    assert followed(loop, 0.5) == 0.0
    assert followed(loop, 0.3) == pytest.approx(-2.0 * 0.2 / 5.0)


def test_steering_does_its_work_at_any_airspeed():
    """What is asked turns the kite by P times the error, however fast it flies and however well it turns."""
    for airspeed in (5.0, 20.0, 60.0):
        for turn_k in (0.125, 0.5, 2.0):
            asked = followed(Loop(TURN_K=turn_k), 0.6, airspeed=airspeed)
            assert turn_k * airspeed * asked == pytest.approx(2.0 * 0.1)


def test_feed_forward_is_a_share_of_the_targets_rate():
    for share in (0.0, 0.25, 1.0):
        assert followed(Loop(FF_GAIN=share), 0.5, rate=1.5) == pytest.approx(share * 1.5 / 5.0)


def test_the_kites_own_turning_is_cancelled():
    assert followed(Loop(TURN_OFFSET=0.25), 0.5) == pytest.approx(-0.25 / 5.0)
    loop = Loop(GRAVITY_C=10.0)
    for heading in (0.0, 1.0, -1.0, math.pi):  # the nose counts here, not the course
        expected = -10.0 / 20.0 * math.sin(heading) * math.cos(0.8) / 5.0
        assert followed(loop, 0.5, heading=heading) == pytest.approx(expected, abs=1e-15)


def test_all_terms_together_make_the_kite_turn_as_wanted():
    """Put what is asked into the turning-rate law: what comes out is FF d(theta_t)/dt + P error."""
    loop = Loop(TURN_OFFSET=0.125, GRAVITY_C=5.0, FF_GAIN=0.5)
    asked = followed(loop, 0.4, rate=0.6, heading=1.2, airspeed=25.0)
    turning = 0.25 * 25.0 * asked + 0.125 + 5.0 / 25.0 * math.sin(1.2) * math.cos(0.8)
    assert turning == pytest.approx(0.5 * 0.6 + 2.0 * -0.1)


def test_the_airspeed_has_a_floor():
    loop = Loop(AIRSPEED_MIN=4.0)
    at_floor = followed(loop, 0.6, airspeed=4.0)
    assert (at_floor, loop.status) == (pytest.approx(0.2), 0)
    for slow in (0.0, 1.0, math.nextafter(4.0, 0.0)):
        assert followed(loop, 0.6, airspeed=slow) == at_floor
        assert loop.status == KITE_STATUS_AIRSPEED_FLOOR
    followed(loop, 0.6, airspeed=math.nextafter(4.0, 5.0))
    assert loop.status == 0


def test_the_shorter_way_round_is_taken():
    loop = Loop()
    assert followed(loop, -3.1, course=3.1) == pytest.approx(2.0 * (2.0 * math.pi - 6.2) / 5.0)
    assert followed(loop, 3.1, course=-3.1) == pytest.approx(-2.0 * (2.0 * math.pi - 6.2) / 5.0)
    followed(loop, math.pi, course=0.0)
    assert loop.error == math.pi
    followed(loop, -math.pi, course=0.0)  # the way round is as long as the other: one of them, and always the same
    assert loop.error == math.pi
    followed(loop, math.nextafter(math.pi, 4.0), course=0.0)
    assert loop.error == pytest.approx(-math.pi)
    followed(loop, math.nextafter(math.pi, 0.0), course=0.0)
    assert loop.error == pytest.approx(math.pi)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("limit", [0.0625, 0.5, 1.0])
def test_saturation_at_its_boundary_and_one_step_to_either_side(limit, sign):
    loop = Loop(STEER_MAX=limit)
    for wanted, asked, status in (
        (math.nextafter(limit, 0.0), math.nextafter(limit, 0.0), 0), (limit, limit, 0),
        (math.nextafter(limit, 2.0), limit, KITE_STATUS_SATURATED), (1e9, limit, KITE_STATUS_SATURATED),
        (math.inf, limit, KITE_STATUS_SATURATED)):
        loop.hold(sign * wanted, PERIOD_S)
        assert (loop.asked, loop.status) == (sign * asked, status)
    loop.follow(0.5 + sign * 3.0, 0.0, kite(airspeed=4.0), loop.gains, PERIOD_S)
    assert (loop.asked, loop.status) == (sign * limit, KITE_STATUS_SATURATED)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_slew_at_its_boundary_and_one_step_to_either_side(sign):
    """4 /s in 1/64 s: 0.0625 a tick."""
    most = 0.0625
    for wanted, asked, status in (
        (math.nextafter(most, 0.0), math.nextafter(most, 0.0), 0), (most, most, 0),
        (math.nextafter(most, 1.0), most, KITE_STATUS_SLEWED),
        (1.0, most, KITE_STATUS_SLEWED), (7.0, most, KITE_STATUS_SLEWED | KITE_STATUS_SATURATED)):
        loop = Loop(STEER_RATE=4.0)
        loop.hold(sign * wanted, 1.0 / 64.0)
        assert (loop.asked, loop.status) == (sign * asked, status)


def test_a_slewed_step_arrives_and_comes_back():
    loop = Loop(STEER_RATE=4.0)
    there = [loop.asked for _ in range(20) if loop.hold(1.0, 1.0 / 64.0) is None]
    assert there == [min(1.0, 0.0625 * tick) for tick in range(1, 21)]
    assert loop.status == 0
    back = [loop.asked for _ in range(40) if loop.hold(-1.0, 1.0 / 64.0) is None]
    assert back == [max(-1.0, 1.0 - 0.0625 * tick) for tick in range(1, 41)]


@settings(deadline=None, max_examples=300)
@given(any_float32, any_float32, any_float32, any_float32, st.floats(0.0, 1e6, width=32), any_float32,
       st.floats(-0.0625, 0.0625), st.sampled_from([0.0, 0.5, 100.0]))
@example(3e38, 3e38, -3e38, 3e38, 0.0, 3e38, 0.0625, 0.5)
def test_the_output_is_finite_and_within_limits(target, rate, course, heading, airspeed, elevation, before, rate_limit):
    """For any input, with all gains at their greatest and the divisors at their least."""
    loop = Loop(STEER_MAX=0.0625, STEER_RATE=rate_limit, INNER_P=50.0, FF_GAIN=1.0, GRAVITY_C=20.0,
                    TURN_OFFSET=-1.0, TURN_K=0.0009765625, AIRSPEED_MIN=0.5)
    loop.hold(before, 1.0)
    before = loop.asked
    asked = followed(loop, target, rate, course=course, heading=heading, airspeed=airspeed, elevation=elevation)
    assert -0.0625 <= asked <= 0.0625
    assert abs(loop.error) <= math.pi
    if rate_limit:
        assert abs(asked - before) <= rate_limit * PERIOD_S * (1 + 1e-12)
