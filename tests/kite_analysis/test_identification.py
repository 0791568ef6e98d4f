"""The turning-rate law and the actuator, identified from real flights (data: see tests/data/flight/README.md) and
from flights whose law is known."""

from pathlib import Path

import numpy as np
import pytest

from kite_analysis.figure_eight import turning_angle
from kite_analysis.flights.description import FlightDataError
from kite_analysis.flights.reader import read_record
from kite_analysis.flights.record import FlightRecord, as_recorded
from kite_analysis.identification.actuator_fit import identify_actuator
from kite_analysis.identification.actuator_model import ActuatorModel, follow
from kite_analysis.identification.turning_rate_fit import identify_law, identify_together, score
from kite_analysis.identification.turning_rates import law_rows

FLIGHTS = sorted((Path(__file__).parent.parent / "data" / "flight").glob("*.csv.gz"))
PERIOD_S = 0.1
K, GRAVITY, OFFSET = 0.2, 3.5, 0.1


def record(time_s, **columns) -> FlightRecord:
    """A record every 0.1 s of the given columns, the rest missing."""
    return as_recorded(time_s, columns, "made up", smoothing_s=1.1, smooth_both=False)._replace(period_s=PERIOD_S)


def flown(steering, disturbance=None) -> FlightRecord:
    """A flight that obeys the law with K, GRAVITY and OFFSET, on a given path, and `disturbance` (n,) [rad/s]."""
    time_s = np.arange(len(steering)) * PERIOD_S
    airspeed = 18.0 + 3.0 * np.sin(0.5 * time_s)
    azimuth, elevation = 0.35 * np.sin(0.26 * time_s), 0.6 + 0.08 * np.sin(0.52 * time_s)
    meridians = -np.sin(elevation) * np.gradient(azimuth, time_s)
    forced = K * airspeed * steering + OFFSET + meridians + (0.0 if disturbance is None else disturbance)
    gravity = GRAVITY / airspeed * np.cos(elevation)
    heading = np.zeros(len(time_s))
    for row in range(len(time_s) - 1):  # Heun
        before = forced[row] + gravity[row] * np.sin(heading[row])
        after = forced[row + 1] + gravity[row + 1] * np.sin(heading[row] + PERIOD_S * before)
        heading[row + 1] = heading[row] + PERIOD_S * 0.5 * (before + after)
    return record(time_s, azimuth=azimuth, elevation=elevation, heading=heading, airspeed=airspeed, steering=steering,
                  distance=np.full(len(time_s), 250.0))


def weaving(seconds: float = 120.0):
    time_s = np.arange(0.0, seconds, PERIOD_S)
    return 0.25 * np.sin(0.52 * time_s) ** 3 - 0.03


def test_a_great_circle_is_a_flight_that_does_not_turn():
    """Meridian convergence is all of the course's rate, wherever the circle goes."""
    angle = np.arange(0.0, 2.0, 0.004)[:, None]
    start, along = np.array([0.8, -0.5, np.sqrt(0.11)]), np.array([0.1, 0.6, 0.4])
    along -= (along @ start) * start
    along /= np.linalg.norm(along)
    position = np.cos(angle) * start + np.sin(angle) * along
    course = np.unwrap(turning_angle(position, np.cos(angle) * along - np.sin(angle) * start))
    x, y, z = position.T
    flight = record(PERIOD_S * np.arange(len(angle)), azimuth=np.unwrap(np.arctan2(y, x)), elevation=np.arcsin(z),
                    course=course, airspeed=np.full(len(x), 20.0), steering=np.zeros(len(x)))
    rows = law_rows(flight, "course", True)
    assert np.max(np.abs(rows.rate)) > 0.02
    assert np.max(np.abs(rows.rate - rows.transport)) < 1e-3 * np.max(np.abs(rows.rate))


def test_smoothing_both_sides_costs_nothing_and_the_rate_alone_a_percent():
    flight = flown(weaving())
    both, alone = identify_law(flight, smooth_both=True), identify_law(flight)
    assert both.k_rad_per_m == pytest.approx(K, rel=1e-3)
    assert both.gravity_m_s2 == pytest.approx(GRAVITY, rel=0.02)
    assert both.offset_rad_s == pytest.approx(OFFSET, rel=0.01)
    assert both.lag_s == pytest.approx(0.0, abs=0.003)
    assert 0.97 * K < alone.k_rad_per_m < 0.995 * K


def test_standard_deviations_hold_when_residuals_are_correlated_over_a_second():
    """Errors over their standard deviation, in 60 flights through gusts, are of size 1 as a whole."""
    steering = weaving()
    errors = []
    for seed in range(60):
        gust = np.zeros(len(steering))
        kicks = np.random.default_rng(seed).normal(0.0, 0.03, len(steering))
        for row in range(1, len(gust)):
            gust[row] = 0.9 * gust[row - 1] + kicks[row]
        fit = identify_law(flown(steering, disturbance=gust), smooth_both=True)
        errors += [(fit.k_rad_per_m - K) / fit.k_rad_per_m_std, (fit.gravity_m_s2 - GRAVITY) / fit.gravity_m_s2_std,
                   (fit.offset_rad_s - OFFSET) / fit.offset_rad_s_std]
    assert 0.75 < np.sqrt(np.mean(np.square(errors))) < 1.3


def test_lag_is_found_and_one_beyond_the_search_is_said_to_be_missing():
    steering = weaving()
    flight = flown(steering)
    late = flight._replace(steering=np.roll(steering, -3))  # recorded 0.3 s before it acts
    assert identify_law(late, smooth_both=True).lag_s == pytest.approx(0.3, abs=0.005)
    much_later = flight._replace(steering=np.roll(steering, -15))
    assert identify_law(much_later).lag_s is None


@pytest.mark.parametrize(("change", "message"), [
    ({"steering": np.zeros(1200)}, "hardly moves"),
    ({"airspeed": np.full(1200, np.nan)}, "no airspeed"),
    ({"heading": np.full(1200, np.nan)}, "no heading in the part"),
    ({"selected": np.arange(1200) < 30}, "at least 5 s are needed"),
    ({"elevation": np.where(np.arange(1200) % 9, 0.6, np.nan)}, "only 0.0 s"),
])
def test_a_flight_that_cannot_tell_says_why(change, message):
    with pytest.raises(FlightDataError, match=message):
        identify_law(flown(weaving())._replace(**change), angle="heading")


def test_a_flight_with_little_steering_owns_up_to_knowing_little():
    gust = np.convolve(np.random.default_rng(3).normal(0.0, 0.1, 1200), np.ones(8) / 8, "same")
    fit = identify_law(flown(0.02 * weaving(), disturbance=gust))
    assert fit.k_rad_per_m_std > 0.2 * K
    assert abs(fit.k_rad_per_m - K) < 4.0 * fit.k_rad_per_m_std


@pytest.mark.parametrize("path", FLIGHTS, ids=lambda path: path.name[9:13])
def test_real_flights_obey_the_law(path):
    flight = read_record(path)
    fit = identify_law(flight)
    assert (fit.angle, fit.transport, fit.steering) == ("heading", True, "actual")
    assert fit.r2 > 0.985
    assert 0.205 < fit.k_rad_per_m < 0.225
    assert 0.001 < fit.k_rad_per_m_std < 0.005
    assert fit.lag_s is not None and -0.05 < fit.lag_s < 0.1
    assert 0.10 < fit.offset_rad_s < 0.12
    without = identify_law(flight, transport=False)
    assert without.r2 < fit.r2  # so meridian convergence is real
    assert 0.5 < without.gravity_m_s2 - fit.gravity_m_s2 < 1.3
    course = identify_law(flight._replace(heading=np.full(len(flight.heading), np.nan)))
    assert course.angle == "course" and 0.94 < course.r2 < fit.r2


@pytest.mark.parametrize("path", FLIGHTS, ids=lambda path: path.name[9:13])
def test_one_half_of_a_reel_out_tells_about_the_other(path):
    flight = read_record(path)
    used_s = flight.time_s[flight.selected]
    middle_s = 0.5 * (used_s[0] + used_s[-1])
    halves = flight.between(0.0, middle_s), flight.between(middle_s, used_s[-1])
    fits = [identify_law(half) for half in halves]
    assert fits[0].k_rad_per_m == pytest.approx(fits[1].k_rad_per_m, rel=0.05)
    for fit, own, other in ((fits[0], *halves), (fits[1], *halves[::-1])):
        assert score(other, fit) > score(own, fit) - 0.02


@pytest.mark.parametrize("path", FLIGHTS, ids=lambda path: path.name[9:13])
def test_the_real_actuator(path):
    flight = read_record(path)
    fit = identify_actuator(flight)
    assert 0.45 < fit.dead_time_s < 0.55
    assert 0.03 < fit.dead_time_s_std < 0.06
    assert fit.rate_limit_per_s is not None and 0.18 < fit.rate_limit_per_s < 0.22
    assert fit.actuator_r2 > 0.989
    # Commands of the reel-out end at 0.35, where the steering follows them: nothing shows where it would stop.
    assert np.max(np.abs(flight.set_steering[flight.selected])) == pytest.approx(0.35, abs=1e-3)
    assert fit.saturation is None and fit.steering_reached == pytest.approx(0.35, abs=1e-3)


@pytest.mark.parametrize(("dead_time_s", "rate", "saturation"), [
    (0.37, 0.3, 0.22), (0.5, 0.3, np.inf), (0.25, np.inf, 0.22), (0.0, 0.3, 0.22)])
def test_an_actuator_is_found_with_the_limits_that_it_came_to(dead_time_s, rate, saturation):
    rng = np.random.default_rng(1)
    commands = np.repeat(rng.uniform(-0.3, 0.3, 100), 12)
    model = ActuatorModel(dead_time_s, rate, saturation)
    position = follow(model, commands, PERIOD_S, np.array([0]), np.zeros(1), len(commands) - 1)[:, 0]
    measured = position + rng.normal(0.0, 0.003, len(position))
    fit = identify_actuator(record(PERIOD_S * np.arange(len(commands)), steering=measured, set_steering=commands))
    assert fit.dead_time_s == pytest.approx(dead_time_s, abs=0.02 if np.isfinite(rate) else 0.1)
    for found, true in ((fit.rate_limit_per_s, rate), (fit.saturation, saturation)):
        assert (found is None) if np.isinf(true) else found == pytest.approx(true, rel=0.02)
    assert fit.actuator_r2 > 0.99


def test_an_actuator_at_rest_tells_nothing():
    still = np.zeros(600)
    with pytest.raises(FlightDataError, match="hardly moves"):
        identify_actuator(record(PERIOD_S * np.arange(600), steering=still, set_steering=still))


def test_flights_are_fitted_together_as_one_kite():
    flights = [read_record(path) for path in FLIGHTS]
    single = [identify_law(flight) for flight in flights]
    together = identify_together(flights)
    assert min(fit.k_rad_per_m for fit in single) < together.k_rad_per_m < max(fit.k_rad_per_m for fit in single)
    assert together.seconds == pytest.approx(np.sum([fit.seconds for fit in single]))
