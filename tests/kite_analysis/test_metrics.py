"""The numbers of a flight, of tracks that are made up."""

import numpy as np
import pytest

from kite_analysis.metrics import Track, measure

PERIOD_S = 0.02


def track(seconds: float = 20.0, **changes: np.ndarray) -> Track:
    """A kite that stands still in TRACK, without steering."""
    time_s = np.arange(round(seconds / PERIOD_S)) * PERIOD_S
    zero = np.zeros_like(time_s)
    still = Track(time_s, zero, zero + 0.5, zero, zero, zero, zero, zero, zero, zero, zero + 1.0, 0.6)
    return still._replace(**changes)


TIME_S = track().time_s


def test_travel_is_what_the_steering_moves_to_either_side_per_second():
    triangle = 0.1 * np.abs((TIME_S / 2.0) % 2.0 - 1.0)  # 0.1 in 2 s, up and down
    metrics = measure(track(steering=triangle, steering_asked=10.0 * triangle), 10.0, None)
    assert metrics.steering_travel_per_s == pytest.approx(0.05)
    assert metrics.steering_asked_travel_per_s == pytest.approx(0.5)


def test_what_happens_before_the_measured_time_counts_for_nothing():
    early = TIME_S < 10.0 - 1e-9
    metrics = measure(track(
        steering=np.where(early, np.sin(TIME_S), 0.3), elevation=np.where(early, 0.1, 0.5 + 0.01 * TIME_S),
        tether_force=np.where(early, 5000.0, 100.0 * TIME_S)), 10.0, None)
    assert metrics.steering_travel_per_s == 0.0
    assert metrics.least_elevation_rad == pytest.approx(0.6)
    assert metrics.peak_tether_force_n == pytest.approx(100.0 * TIME_S[-1])


def test_time_out_of_track_and_the_leap_across_it_do_not_count():
    away = (TIME_S > 12.0) & (TIME_S < 16.0)
    steering = np.where(TIME_S < 14.0, 0.0, 0.4)
    metrics = measure(track(steering=steering, in_track=1.0 - away, elevation=np.where(away, 0.2, 0.5)), 10.0, None)
    assert metrics.steering_travel_per_s == 0.0 and metrics.least_elevation_rad == 0.5


def test_a_plant_without_forces_has_no_tether_force_and_a_single_tick_no_travel():
    assert measure(track(), 10.0, None).peak_tether_force_n is None
    assert measure(track(), 10.0, None).least_elevation_rad == 0.5
    alone = measure(track(), TIME_S[-1], None)
    assert alone.steering_travel_per_s is None and alone.least_elevation_rad == 0.5


def test_a_flight_that_is_not_measured_has_none_of_the_numbers():
    *numbers, verdict, trouble = measure(track(), 30.0, None)
    assert set(numbers) == {None} and verdict == "not measured" and "run.settle_s = 30 s" in (trouble or "")
