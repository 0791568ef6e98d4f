"""Plots of flights: what is drawn is what was flown, and nothing is drawn over it."""

import numpy as np
import pytest

from kite_analysis.figure_eight import TargetEight
from kite_analysis.metrics import Track
from kite_analysis.plots import plot_flight

pytest.importorskip("matplotlib")
EIGHT = TargetEight(0.0, 0.7, 0.6, 0.2)


def spinning(turns: float) -> Track:
    """A kite that spins round and round, as an unstable one does, while its target stands still."""
    time_s = np.linspace(0.0, 20.0, 1000)
    course = (2.0 * np.pi * turns * time_s / time_s[-1] + np.pi) % (2.0 * np.pi) - np.pi
    azimuth, elevation = EIGHT.angles(time_s)
    zero = np.zeros_like(time_s)
    return Track(time_s, azimuth, elevation, course, zero + 0.5, zero + 0.1, zero + 0.3, zero + 0.3, zero, zero,
                 zero + 1.0, 0.6)


def test_no_line_of_the_target_leaps_by_a_turn_where_an_unstable_kite_spins():
    figure = plot_flight(spinning(turns=5.0), EIGHT, "spinning")
    (angle,) = [axes for axes in figure.axes if "turning angle" in axes.get_ylabel()]
    drawn = {line.get_label(): np.asarray(line.get_ydata(), float) for line in angle.lines}
    flown, target = drawn[r"flown $\theta$"], drawn[r"target $\theta_t$"]
    assert flown[-1] - flown[0] == pytest.approx(5 * 360.0)
    known = np.isfinite(target)
    assert known.sum() > 980
    assert np.abs(target - flown)[known].max() <= 180.0
    assert np.nanmax(np.abs(np.diff(target))) < 1.0


def test_cross_track_error_and_steering_are_drawn_as_flown_below_the_turning_angle():
    figure = plot_flight(spinning(turns=1.0), EIGHT, "spinning")
    drawn = {axes.get_ylabel().replace("\n", " "): axes.lines[0].get_ydata() for axes in figure.axes}
    assert drawn["cross-track error [deg]"] == pytest.approx(np.degrees(0.1))
    assert drawn["actual steering"] == pytest.approx(0.3)
