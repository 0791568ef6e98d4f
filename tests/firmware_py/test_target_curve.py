"""The target curve against numpy's and against numeric differentiation, and which curves are refused."""

import math

import numpy as np
import pytest
from eights import beside, eight, flyable, parameters
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_py.control.figure_eight import CurveCheck
from kite_analysis.figure_eight import great_circle_distance

LINE_LENGTH = 100.0
path_parameters = st.floats(-10.0, 10.0)


def problem(line_length: float = LINE_LENGTH, **changed: float) -> str | None:
    """What the firmware has against this eight, by a check that comes to an end."""
    check = CurveCheck()
    check.begin(parameters(**changed), line_length)
    for _ in range(20):
        check.advance()
    assert check.done
    return check.problem


def tightest_turn(shape: dict[str, float]) -> float:
    """Angular radius [rad] of the tightest turn of an eight, from 2000 points of it."""
    curve, _ = eight(**shape)
    return 1.0 / max(abs(curve.geodesic_curvature(s)) for s in np.linspace(0.0, 2.0 * math.pi, 2000))


@settings(deadline=None)
@given(flyable(), path_parameters)
def test_position_and_derivative_agree_with_numpy(shape, s):
    curve, numpy_eight = eight(**shape)
    here = np.array([s])
    *position, dx, dy, dz = curve.at(s)
    assert position == pytest.approx(numpy_eight.position(here)[0], abs=1e-12)
    assert (dx, dy, dz) == pytest.approx(numpy_eight.derivatives(here)[0][0], abs=1e-7)


@settings(deadline=None)
@given(flyable(), path_parameters)
def test_geodesic_curvature_is_the_turning_of_the_tangent_in_the_tangent_plane(shape, s):
    """gamma . (gamma' x gamma'') / |gamma'|^3, positive where the turning angle grows along s."""
    curve, numpy_eight = eight(**shape)
    position = numpy_eight.position(np.array([s]))[0]
    first, second = (derivative[0] for derivative in numpy_eight.derivatives(np.array([s])))
    expected = np.dot(position, np.cross(first, second)) / np.linalg.norm(first) ** 3
    assert curve.geodesic_curvature(s) == pytest.approx(expected, abs=1e-5, rel=1e-5)


def test_geodesic_curvature_has_the_turning_angles_sign():
    """Carry the tangent 1 mrad along the curve: the turning angle grows by the curvature (and the meridian's turn)."""
    curve, numpy_eight = eight()
    for s in (0.3, 1.2, 2.0, 4.0, 5.5):
        step = 1e-3
        before, behind = numpy_eight.course(np.array([s, s + step]))
        here, there = numpy_eight.position(np.array([s, s + step]))
        length = float(great_circle_distance(here, there))
        azimuths, elevations = numpy_eight.angles(np.array([s, s + step]))
        meridian = (azimuths[1] - azimuths[0]) * math.sin(elevations.mean())
        turned = (behind - before + math.pi) % (2 * math.pi) - math.pi
        expected = (turned + meridian) / length
        assert curve.geodesic_curvature(s + 0.5 * step) == pytest.approx(expected, rel=1e-3, abs=1e-3)


@settings(deadline=None)
@given(flyable())
def test_the_tightest_turn_is_found_within_an_eighth(shape):
    """A line that is long enough is never refused, one that is an eighth too short always is."""
    enough = 1.0 / tightest_turn(shape) / 0.25
    shape |= {"EIGHT_LEAST_EL": 0.0, "WINDOW_ANGLE": 90.0}
    assert problem(1.0001 * enough, **shape) is None
    assert "kite manages" in str(problem(0.875 * enough, **shape))


def test_the_default_eight_is_flown():
    assert problem() is None


@pytest.mark.parametrize(
    ("changed", "line_length", "message"),
    [
        ({"EIGHT_ELEVATION": 17.0}, 100.0, "eight goes down to 9.0 deg, minimum is 10.0"),
        ({"EIGHT_ELEVATION": 30.0, "EIGHT_HALF_H": 40.0, "EIGHT_LEAST_EL": 0.0}, 100.0,
         "eight goes down to -10.0 deg, minimum is 0.0"),
        ({"EIGHT_ELEVATION": 78.0}, 100.0, "eight goes over the zenith"),
        ({"EIGHT_AZIMUTH": 60.0}, 100.0, "eight leaves the wind window of 75 deg"),
        ({"EIGHT_AZIMUTH": -60.0}, 100.0, "eight leaves the wind window of 75 deg"),
        ({"WINDOW_ANGLE": 40.0}, 100.0, "eight leaves the wind window of 40 deg"),
        ({}, 20.0, "eight needs 5.4 deg radius, kite manages 11.5"),
        ({"STEER_MAX": 0.25}, 100.0, "eight needs 5.4 deg radius, kite manages 9.17"),
        ({"TURN_K": 0.0009765625, "STEER_MAX": 0.0625}, 1.0, "eight needs 5.4 deg radius, kite manages 9.39e+05"),
        ({"TURN_K": 0.0009765625, "STEER_MAX": 0.0625}, 1e-30, "eight needs 5.4 deg radius, kite manages 5.73e+07"),
    ],
)
def test_refusals_say_why_in_fifty_characters(changed, line_length, message):
    assert problem(line_length, **changed) == message
    assert len(message.encode()) <= 50


@settings(deadline=None, max_examples=200)
@given(st.data())
def test_any_setting_there_can_be_is_judged_in_fifty_characters(data):
    """Whatever the parameters, the answer is a sentence that a STATUSTEXT holds, or none."""
    numbers = {
        "EIGHT_AZIMUTH": (-60.0, 60.0), "EIGHT_ELEVATION": (5.0, 85.0), "EIGHT_HALF_W": (1.0, 80.0),
        "EIGHT_HALF_H": (0.5, 40.0), "EIGHT_LEAST_EL": (0.0, 60.0), "WINDOW_ANGLE": (10.0, 90.0),
        "TURN_K": (0.0009765625, 16.0), "STEER_MAX": (0.0625, 1.0)}
    changed = {name: data.draw(st.floats(*limits, width=32)) for name, limits in numbers.items()}
    text = problem(data.draw(st.floats(2.0**-149, 1e6)), **changed)
    assert text is None or 10 < len(text.encode()) <= 50


def test_limits_at_their_boundary_and_one_step_to_either_side():
    step = 2.0**-18  # one step of float32 at 32 degrees
    assert problem(EIGHT_LEAST_EL=32.0) is None  # the default eight goes from 32 to 48 deg
    assert problem(EIGHT_LEAST_EL=32.0 - step) is None
    assert "goes down" in str(problem(EIGHT_LEAST_EL=32.0 + step))
    assert problem(EIGHT_ELEVATION=77.0, WINDOW_ANGLE=90.0, TURN_K=16.0) is None
    assert "zenith" in str(problem(EIGHT_ELEVATION=77.0 + 2 * step, WINDOW_ANGLE=90.0, TURN_K=16.0))

    curve, _ = eight()
    curvature = max(abs(curve.geodesic_curvature(math.pi * index / 24)) for index in range(24))
    assert problem(curvature / 0.25 * 1.000001) is None
    assert "kite manages" in str(problem(curvature / 0.25 * 0.999999))


@pytest.mark.parametrize("azimuth", [-30.0, 0.0, 30.0])
def test_the_wind_window_holds_on_both_sides(azimuth):
    curve, _ = eight(EIGHT_AZIMUTH=azimuth)
    widest = max(math.degrees(math.acos(curve.at(2 * math.pi * index / 480)[0])) for index in range(480))
    assert problem(EIGHT_AZIMUTH=azimuth, WINDOW_ANGLE=widest + 0.01) is None
    assert "window" in str(problem(EIGHT_AZIMUTH=azimuth, WINDOW_ANGLE=widest - 0.2))


def test_least_elevations_of_whole_degrees_are_not_refused_for_a_rounding():
    for elevation in range(20, 60):
        for half_height in range(4, 10):
            shape = {"EIGHT_ELEVATION": float(elevation), "EIGHT_HALF_H": float(half_height), "TURN_K": 16.0}
            assert problem(EIGHT_LEAST_EL=float(elevation - half_height), **shape) is None, shape


def test_beside_is_beside():
    """The helper of the tests of guidance, which all of them lean on."""
    _, numpy_eight = eight()
    position = beside(numpy_eight, 1.0, 0.02)
    assert np.linalg.norm(position) == pytest.approx(1.0)
    s, distance = numpy_eight.nearest(position[np.newaxis])
    assert (s[0], distance[0]) == pytest.approx((1.0, 0.02), abs=1e-6)
