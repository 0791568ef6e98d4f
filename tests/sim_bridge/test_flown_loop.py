"""The loop as it is flown, by law: limits and errors of the equation against flights of the firmware."""

import math

import numpy as np
import pytest

from kite_analysis.angles import wrap
from kite_analysis.delay.characteristic_roots import Gains, Loop
from kite_analysis.delay.flown_loop import FlownLoop, flown_limit, following_error, turning_of
from kite_analysis.delay.whole_loop import gain_limit
from kite_analysis.figure_eight import TargetEight
from sim_bridge.flight.flight import Flight
from sim_bridge.flight.truth_columns import COLUMNS
from sim_bridge.runtimes.memory import MemoryRuntime
from sim_bridge.scenario.scenario import load_scenario

FF_FILTER_S = 0.125


def flown(scenario: str, *settings: str, **parameters: float) -> tuple[float, float]:
    """RMS of cross-track and turning-angle error [rad] over the last 20 s of 45, as the firmware sees them."""
    chosen = load_scenario(scenario)
    for text in settings:
        chosen.set_text(text, "--set")
    for name, value in parameters.items():
        chosen.set_parameter(name, value, "here")
    flight = Flight(chosen, MemoryRuntime())
    flight.fly(45.0)
    states = dict(zip(COLUMNS, np.array(flight.rows[-1000:]).T, strict=True))
    turning = wrap(states["state_course_rad"] - states["target_course_rad"])
    return float(np.sqrt(np.mean(states["cross_track_rad"] ** 2))), float(np.sqrt(np.mean(turning**2)))


@pytest.mark.parametrize(("delay_s", "speed", "outer_l"), [(0.2, 0.2, 5.0), (0.2, 0.45, 3.0), (0.35, 0.3, 2.0),
                                                           (0.5, 0.06, 4.0)])
def test_the_plain_law_is_the_whole_loop(delay_s, speed, outer_l):
    loop = FlownLoop(delay_s, 50.0, speed)
    assert flown_limit(loop, outer_l) == pytest.approx(gain_limit(Loop(delay_s + 0.01, speed), outer_l), rel=1e-3)
    assert flown_limit(loop, 3.0 / (speed * delay_s)) == 0.0


@pytest.mark.parametrize(("scenario", "speed", "outer_l"), [("paper-delay-tuned", 0.2, 5.0),
                                                            ("small-kite-paper", 0.45, 3.0)])
def test_what_is_fed_forward_lowers_the_limit(scenario, speed, outer_l):
    """It tracks at nine tenths of the limit, and does not at 1.15 of it, though the whole loop's limit is beyond."""
    limit = flown_limit(FlownLoop(0.2, 50.0, speed, 1.0, FF_FILTER_S), outer_l)
    assert 1.15 * limit < gain_limit(Loop(0.21, speed), outer_l)
    swinging = [flown(scenario, FF_GAIN=1.0, OUTER_L=outer_l, INNER_P=share * limit)[1] for share in (0.9, 1.15)]
    assert swinging[0] < math.radians(45.0) < swinging[1]


@pytest.mark.parametrize(("predicted_s", "outer_l"), [(0.16, 6.5), (0.25, 6.5), (0.25, 3.0)])
def test_a_wrong_prediction_has_a_limit_and_a_right_one_has_none(predicted_s, outer_l):
    """An actuator without limits, so that nothing but the delay is wrong. Where it is right, sampling alone is left."""
    assert flown_limit(FlownLoop(0.2, 50.0, 0.45, 1.0, 0.0, 0.2), outer_l) == 50.0
    limit = flown_limit(FlownLoop(0.2, 50.0, 0.45, 1.0, 0.0, predicted_s), outer_l)
    errors = [flown("small-kite", "actuator.rate_limit_per_s=0", PRED_DELAY=predicted_s, PRED_RATE=0.0,
                    OUTER_L=outer_l, INNER_P=share * limit)[1] for share in (0.85, 1.4)]
    assert errors[0] < math.radians(3.0) and errors[1] > 2.5 * errors[0]


@pytest.mark.parametrize(("scenario", "speed", "outer_l", "feed_forward"), [
    ("paper-delay-tuned", 0.2, 5.0, 0.0), ("paper-delay-tuned", 0.2, 2.0, 0.0), ("small-kite-paper", 0.45, 3.0, 0.0),
    ("paper-delay-tuned", 0.2, 5.0, 1.0)])
def test_the_error_on_the_eight_falls_with_p_as_the_equation_says(scenario, speed, outer_l, feed_forward):
    """Errors are not small here, and atan flattens them: flown ones are some 0.5 to 1 of the equation's. Which of two
    gains follows better, and the paper's optimum is not the best of them, both say alike."""
    loop = FlownLoop(0.2, 50.0, speed, feed_forward, FF_FILTER_S)
    eight = TargetEight.from_parameters(load_scenario(scenario).parameter)
    gains = [1.75, 2.8, 4.5]
    said = [following_error(loop, Gains(gain, outer_l), eight) for gain in gains]
    seen = [flown(scenario, FF_GAIN=feed_forward, OUTER_L=outer_l, INNER_P=gain)[0] for gain in gains]
    assert said == sorted(said, reverse=True) and seen == sorted(seen, reverse=True)
    shares = np.array(seen) / said
    assert np.all((shares > 0.45) & (shares < 1.05))


def test_the_eights_turning_makes_no_turn_of_its_own():
    """A figure of eight turns as far to the left as to the right; a faster kite turns faster by as much."""
    eight = TargetEight(0.1, 0.6, 0.5, 0.2)
    rate, period_s = turning_of(eight, 0.3)
    assert np.mean(rate) == pytest.approx(0.0, abs=0.05 * np.abs(rate).max())
    faster, shorter_s = turning_of(eight, 0.6)
    assert faster == pytest.approx(2.0 * rate) and shorter_s == pytest.approx(0.5 * period_s)
