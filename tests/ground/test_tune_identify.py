"""tune --identify: what the telemetry tells of the kite is what flies, and the predictor gets it."""

import json

import pytest


def test_a_kite_is_identified_in_flight_and_flies_better_for_it(flying_kite, operator_of):
    """small-kite-paper with K set wrong by 10 %: K and 0.2 s of delay are found, and prediction with them takes most
    of the error away. The steering changes too little from tick to tick to show the actuator's 4 1/s."""
    operator = operator_of(flying_kite("small-kite-paper", TURN_K=0.33))
    assert operator.runs("tune", "--identify", "--yes", "--json") == 0
    found = json.loads(operator.said)
    assert found["law"]["k_rad_per_m"] == pytest.approx(0.3, rel=0.03)
    assert 0.0 < found["law"]["k_rad_per_m_std"] < 0.02
    assert found["delay_s"] == pytest.approx(0.2, abs=0.01)
    assert found["written"] is True
    assert found["after"]["cross_track_rad"] < 0.3 * found["before"]["cross_track_rad"]
    assert operator.kite.firmware_parameter("PRED_DELAY") == pytest.approx(0.2, abs=0.01)
    assert operator.runs("param", "revert", "--yes") == 0
    assert operator.kite.firmware_parameter("TURN_K") == pytest.approx(0.33)
    assert operator.kite.firmware_parameter("PRED_DELAY") == 0.0


def test_a_proposal_is_shown_and_set_only_when_asked_for(flying_kite, operator_of):
    operator = operator_of(flying_kite("small-kite-paper"))
    assert operator.runs("tune", "--identify", "--json") == 0
    found = json.loads(operator.said)
    assert found["written"] is False and found["after"] is None
    assert found["proposed"]["INNER_P"] == pytest.approx(6.1, rel=0.1)
    assert operator.kite.firmware_parameter("INNER_P") == 1.75


@pytest.mark.parametrize(("delay_s", "scenario"), [(0.2, "paper-delay"), (0.12, "paper-delay"), (0.3, "paper-delay")])
def test_the_delay_is_that_of_the_emulated_link(flying_kite, operator_of, delay_s, scenario):
    operator = operator_of(flying_kite(scenario, f"link.control.delay_s={delay_s}", INNER_P=1.2))
    assert operator.runs("tune", "--identify", "--json") == 0
    assert json.loads(operator.said)["delay_s"] == pytest.approx(delay_s, abs=0.005)
