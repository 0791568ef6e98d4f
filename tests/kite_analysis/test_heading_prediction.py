"""Headings predicted with a law that was fitted to other flights (data: see tests/data/flight/README.md)."""

from pathlib import Path

import numpy as np
import pytest

from kite_analysis.flights.description import FlightDataError
from kite_analysis.flights.reader import read_record
from kite_analysis.identification.eight_spread import eight_spread
from kite_analysis.identification.heading_prediction import cross_fits, cross_predictions, fit_model, predict_heading

FLIGHTS = sorted((Path(__file__).parent.parent / "data" / "flight").glob("*.csv.gz"))


@pytest.fixture(scope="module")
def flights():
    return [read_record(path) for path in FLIGHTS]


def test_no_flight_predicts_itself():
    pairs = cross_fits([None] * 3)  # type: ignore[list-item]
    assert len(pairs) == 9
    assert all(not set(fitted) & set(predicted) for fitted, predicted in pairs)


def test_real_headings_are_predicted_within_degrees(flights):
    """The worst of nine cross-fits, over all samples of windows of 2 s and 5 s."""
    errors = {(error.source, error.window_s): error.rms_deg for error in cross_predictions(flights)}
    assert errors["actual", 2.0] < 5.5
    assert errors["actual", 5.0] < 11.0
    assert errors["commanded", 2.0] < 7.0
    assert errors["commanded", 5.0] < 13.0


def test_the_law_is_what_predicts(flights):
    """Without steering, or with that of a kite that turns the other way, headings are off by far more."""
    model = fit_model(flights[:1])
    good = predict_heading(flights[1:], 2.0, "actual", model)
    no_steering = model._replace(law=model.law._replace(k_rad_per_m=0.0))
    wrong_sign = model._replace(law=model.law._replace(k_rad_per_m=-model.law.k_rad_per_m))
    assert predict_heading(flights[1:], 2.0, "actual", no_steering).rms_deg > 5.0 * good.rms_deg
    assert predict_heading(flights[1:], 2.0, "actual", wrong_sign).rms_deg > 10.0 * good.rms_deg
    assert good.end_rms_deg > good.rms_deg


def test_the_actuator_matters_for_predictions_from_the_set_steering(flights):
    model = fit_model(flights[:2])
    assert model.actuator is not None
    good = predict_heading(flights[2:], 2.0, "commanded", model)
    at_once = model._replace(actuator=model.actuator._replace(dead_time_s=0.0))
    assert predict_heading(flights[2:], 2.0, "commanded", at_once).rms_deg > 1.5 * good.rms_deg


def test_what_cannot_be_predicted_says_why(flights):
    model = fit_model(flights[:1])
    with pytest.raises(FlightDataError, match="no unbroken stretch"):
        predict_heading(flights[1:], 500.0, "actual", model)
    with pytest.raises(FlightDataError, match="needs the actuator"):
        predict_heading(flights[1:], 2.0, "commanded", model._replace(actuator=None))
    with pytest.raises(FlightDataError, match="two flights"):
        cross_predictions(flights[:1])


def test_real_eights_repeat_within_a_degree_or_so(flights):
    spreads = [eight_spread(flight) for flight in flights]
    differences = np.concatenate([spread.rms_deg for spread in spreads])
    assert len(differences) >= 5
    assert np.all((differences > 0.3) & (differences < 1.6))
    assert all(19.0 < seconds < 31.0 for spread in spreads for seconds in spread.seconds)
    assert all(spread.climb_deg > 0.0 for spread in spreads)


def test_an_eight_that_repeats_has_no_spread_and_a_wider_one_has_some(flights):
    flight = flights[0]
    s = 0.26 * flight.time_s
    wider = 1.0 + 0.1 * (s > 6 * np.pi)
    everything = np.ones(len(s), dtype=bool)
    same = flight._replace(azimuth=0.36 * np.sin(s), elevation=0.6 + 0.08 * np.sin(2 * s) + 1e-4 * flight.time_s,
                           selected=everything)
    spread = eight_spread(same)
    assert max(spread.rms_deg) < 0.05
    assert max(eight_spread(same._replace(azimuth=wider * same.azimuth)).rms_deg) > 0.5
    with pytest.raises(FlightDataError, match="two complete eights"):
        eight_spread(same.between(0.0, 40.0))
