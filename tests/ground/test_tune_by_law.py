"""`tune` by the law that is flown: what it says of it, and that it proposes nothing that flies worse."""

import json
import math

import pytest

from ground.errors import UsageError
from ground.kite import connect_over

OPTIMUM = 1.8394  # 1 / (e 0.2 s)


def tuned(operator, *options: object) -> dict:
    assert operator.runs("tune", "--json", *options) == 0
    return json.loads(operator.said)


def test_a_predicted_kite_is_left_alone(flying_kite, operator_of):
    """small-kite flies its eight within a tenth of a degree: the delay is out of the loop, the paper's limit is too."""
    operator = operator_of(flying_kite("small-kite"))
    assert operator.runs("tune", "--yes") == 0
    assert "UNSTABLE" not in operator.said and "1 / (e tau)" not in operator.said
    for words in ("flown: prediction over PRED_DELAY = 0.2 s", "follows the eight", "if the delay is 25 % off",
                  "best P for following the eight", "INNER_P stays as it is"):
        assert words in operator.said
    assert "the present gain suits the prediction" in operator.remarked
    assert operator.kite.firmware_parameter("INNER_P") == 6.125


def test_a_predicted_kite_with_a_needlessly_low_gain_gets_a_higher_one(flying_kite, operator_of):
    operator = operator_of(flying_kite("small-kite", INNER_P=1.5, PRED_DELAY=0.19))
    found = tuned(operator, "--yes")
    assert found["written"] and found["proposal"] == pytest.approx(6.3, abs=0.3)
    assert found["step"]["after"]["cross_track_rad"] < found["step"]["before"]["cross_track_rad"]


def test_a_prediction_of_another_delay_than_the_measured_one_is_pointed_out(flying_kite, operator_of):
    operator = operator_of(flying_kite("small-kite", PRED_DELAY=0.1, INNER_P=3.0))
    assert operator.runs("tune", "--json") == 0 and operator.runs("tune", "--yes", "--duration", "10") == 0
    assert "differs from PRED_DELAY: run kite-ground tune --identify" in operator.said


@pytest.mark.parametrize(("scenario", "parameters", "stays"), [
    ("paper-delay-tuned", {"INNER_P": 6.0}, True),
    ("paper-delay-tuned", {"INNER_P": 1.67}, False),
    ("paper-delay-tuned", {"INNER_P": 0.7, "OUTER_L": 3.0}, False),
    ("paper-delay-tuned", {"INNER_P": 2.0, "FF_GAIN": 1.0}, False),
    ("small-kite-paper", {}, True),
    ("small-kite-paper", {"INNER_P": 4.0, "FF_GAIN": 0.0}, True),
])
def test_on_the_eight_nothing_is_proposed_that_flies_worse(flying_kite, operator_of, scenario, parameters, stays):
    """Without prediction: half the limit follows better than the optimum, which is for settling. What follows better
    already, though with less margin, is left alone, and its margin told."""
    operator = operator_of(flying_kite(scenario, **parameters))
    before = operator.kite.firmware_parameter("INNER_P")
    found = tuned(operator, "--yes")
    flown = found["flown"]
    assert flown["law"]["follows_the_eight"] and found["stable"]
    assert flown["measured_rad"] > 0.0 and 0.3 < flown["measured_rad"] / flown["present_rad"] < 2.0
    assert flown["following"] <= 0.5 * flown["limit"] + 1e-9
    if stays:
        assert found["proposal"] is None and not found["written"] and found["step"] is None
        assert operator.kite.firmware_parameter("INNER_P") == before
    else:
        assert found["written"] and found["proposal"] > before
        assert found["step"]["after"]["cross_track_rad"] < 0.9 * found["step"]["before"]["cross_track_rad"]


def test_the_lines_tell_settling_from_following(flying_kite, operator_of):
    operator = operator_of(flying_kite("paper-delay-tuned", INNER_P=6.0))
    assert operator.runs("tune", "--delay", "0.2", "--yes") == 0
    for words in ("flown: plain law: no prediction, no feed-forward",
                  "limit of P, present control law          6.70",
                  "best P for settling                      1.839",
                  "best P for following the eight           3.35",
                  "cross-track error in flight, RMS", "stable, but the gain margin is only 1.1"):
        assert words in operator.said
    assert "no P with a gain margin of 2 follows the eight better" in operator.remarked


def test_a_kite_in_park_settles(flying_kite, operator_of):
    """There the paper's optimum is what is wanted."""
    operator = operator_of(flying_kite("paper-delay-tuned", INNER_P=3.0))
    assert operator.runs("mode", "park") == 0
    found = tuned(operator, "--delay", "0.2")
    assert not found["flown"]["law"]["follows_the_eight"]
    assert found["proposal"] == pytest.approx(OPTIMUM, abs=1e-4)


def test_a_diverging_kite_is_helped_at_once(flying_kite, operator_of):
    """No minute of measuring first: from beyond the limit to the gain that settles, and the next call goes on."""
    kite = flying_kite("paper-delay")
    kite.sleep(10.0)
    began_s, operator = kite.clock(), operator_of(kite)
    found = tuned(operator, "--delay", "0.2", "--yes")
    assert found["flown"]["urgent"] and found["verdict"].startswith("UNSTABLE") and found["written"]
    assert kite.firmware_parameter("INNER_P") == pytest.approx(OPTIMUM, abs=1e-4) and kite.clock() - began_s < 15.0
    kite.sleep(30.0)
    assert math.degrees(kite.flight.recent_errors(10.0)[0]) < 8.0


def test_a_notebook_is_told_the_same(flying_kite):
    with connect_over(flying_kite("paper-delay-tuned", INNER_P=1.67).links(), background=False) as kite:
        delay_s = kite.measure_delay(20.0).loop.whole_s
        assert delay_s is not None
        advice = kite.advise_as_flown(delay_s)
        assert advice.proposal and advice.measured_rad
        assert advice.proposal == pytest.approx(0.5 * advice.limit, rel=1e-3) and 6.6 < advice.limit < 6.8
        assert kite.step_gain(advice.proposal / 1.67, delay_s).after.cross_track_rad < advice.measured_rad


def test_gains_that_follow_a_schedule_are_not_set_by_hand(flying_kite, operator_of):
    operator = operator_of(flying_kite("paper-delay-tuned", GAIN_TAU=0.2))
    found = tuned(operator, "--yes", "--delay", "0.2")
    assert found["proposal"] is None and "GAIN_TAU is set" in found["flown"]["reason"]
    operator.is_told(UsageError, "not set: GAIN_TAU is set", "tune", "--delay", "0.2", "--step", "+10%", "--yes")
