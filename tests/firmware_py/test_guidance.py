"""The outer loop: the nearest point on the right strand, and a direction that leads onto the curve from anywhere."""

import math

import numpy as np
import pytest
from eights import beside, eight, flyable, frame_at, gains, parameters
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from firmware_py.control.figure_eight import FigureEight
from firmware_py.control.guidance import Guidance
from firmware_py.prediction.prediction import PredictionConfig
from firmware_py.sphere import wrap
from kite_analysis.angles import wrap as wrap_array
from kite_analysis.figure_eight import TargetEight, great_circle_distance

PERIOD_S = 0.02
SPEED = 0.2  # of the kite, across the sphere [1/s]
LEFT, RIGHT = 1.0, -1.0  # sides of the curve, seen along its direction of flight from the ground outwards


class OuterLoop(Guidance):
    """The outer loop with the gains of parameters."""

    def __init__(self, curve: FigureEight, **changed: float):
        super().__init__(curve)
        self.config.load(parameters(**changed))
        self._gains = gains(**changed)

    def at(self, frame, dt: float = PERIOD_S) -> None:
        self.step(frame, self._gains, dt)

    def exactly_at(self, kite) -> None:
        self.step_exactly(kite, self._gains)


def guidance_for(**shape: float) -> tuple[OuterLoop, TargetEight]:
    """The outer loop for an eight, and numpy's eight of the same shape."""
    curve, numpy_eight = eight(**shape)
    return OuterLoop(curve, **shape), numpy_eight


def settled_at(guidance: OuterLoop, position, s: float, steps: int = 3) -> None:
    """Let the search run at a standing kite, from the strand at `s`."""
    guidance.path_parameter = s
    for _ in range(steps):
        guidance.at(frame_at(position))


def angle_between(first: float, second: float) -> float:
    return abs(math.remainder(first - second, 2.0 * math.pi))


def moved(position: np.ndarray, course: float, distance: float) -> np.ndarray:
    """Unit position after flying `distance` [rad] from `position` along a great circle with turning angle `course`."""
    frame = frame_at(position)
    direction = math.cos(course) * np.array([frame.e1x, frame.e1y, frame.e1z])
    direction += math.sin(course) * np.array([frame.e2x, frame.e2y, 0.0])
    after = math.cos(distance) * position + math.sin(distance) * direction
    return after / np.linalg.norm(after)


@settings(deadline=None, max_examples=200)
@given(flyable(), st.floats(0.0, 2 * math.pi), st.floats(-0.5, 0.5), st.floats(-0.15, 0.15))
def test_the_nearest_point_is_the_nearest_on_the_strand(shape, s, share, guess_error):
    """Kites beside the curve by up to half its tightest radius, the search starting a few ticks' flight away."""
    guidance, numpy_eight = guidance_for(**shape)
    grid = np.linspace(0.0, 2.0 * math.pi, 720)
    radius = 1.0 / max(abs(guidance.curve.geodesic_curvature(at)) for at in grid[::8])
    position = beside(numpy_eight, s, share * radius)
    settled_at(guidance, position, s + guess_error)
    assert angle_between(guidance.path_parameter, s) < 1e-3
    assert abs(guidance.cross_track) == pytest.approx(abs(share) * radius, abs=1e-4)

    anywhere, distance = numpy_eight.nearest(position[np.newaxis])  # nearer on another strand, near the crossing
    if angle_between(float(anywhere[0]), s) < 0.3:
        assert abs(guidance.cross_track) == pytest.approx(float(distance[0]), abs=1e-4)


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("crossing", [0.0, math.pi])
@pytest.mark.parametrize("offset_deg", [-6.0, -4.0, -2.0, -1.0, 0.0, 1.0, 2.0, 4.0, 6.0])
def test_the_crossing_is_flown_on_one_strand(direction, crossing, offset_deg):
    """A kite flies past the crossing beside its strand: half the way it is nearer to the other one."""
    guidance, numpy_eight = guidance_for(EIGHT_DIRECTION=direction)
    start, end = (crossing - 0.6 * direction, crossing + 0.6 * direction)
    path = np.linspace(start, end, 120)
    settled_at(guidance, beside(numpy_eight, start, math.radians(offset_deg)), start)
    nearer_elsewhere = 0
    for s in path:
        position = beside(numpy_eight, s, math.radians(offset_deg))
        guidance.scan(frame_at(position), float(numpy_eight.course(np.array([s]))[0]))
        guidance.at(frame_at(position))
        assert angle_between(guidance.path_parameter, s) < 0.05
        anywhere, _ = numpy_eight.nearest(position[np.newaxis])
        nearer_elsewhere += angle_between(float(anywhere[0]), s) > 0.5
    if abs(offset_deg) > 1.0:
        assert nearer_elsewhere > 5


@settings(deadline=None, max_examples=100)
@given(flyable(), st.floats(-1.4, 1.4), st.floats(0.09, 1.45), st.floats(-3.1, 3.1))
def test_a_kite_that_goes_where_it_is_told_reaches_the_eight_from_anywhere(shape, azimuth, elevation, course):
    guidance, numpy_eight = guidance_for(**shape)
    position = np.array([math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth),
                         math.sin(elevation)])
    parameters_flown, distances = [], []
    for tick in range(1000):  # 40 s: once round takes some 20 s
        frame = frame_at(position)
        guidance.scan(frame, course)
        if tick >= 40:  # it was parked before, so that the scan has been round once
            guidance.at(frame, 2 * PERIOD_S)
            course = guidance.target_course
            position = moved(position, course, 2 * PERIOD_S * SPEED)
            assert position[2] > -0.1
            parameters_flown.append(guidance.path_parameter)
            distances.append(abs(guidance.cross_track))
    _, true_distances = numpy_eight.nearest(position[np.newaxis])
    assert max(distances[-200:]) < 0.03
    assert true_distances[0] < 0.03
    flown = np.unwrap(parameters_flown[-200:])
    assert numpy_eight.direction * (flown[-1] - flown[0]) > 1.0  # and it flies along it, the right way round


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("s", [0.0, 0.8, 1.6, 2.4, 3.2, 4.0, 4.8, 5.6])
@pytest.mark.parametrize("kite_side", [LEFT, RIGHT])
def test_signs_of_cross_track_and_of_the_turn_back(direction, s, kite_side):
    """A kite left of the curve has the curve on its right: cross-track is negative and the target turns right."""
    guidance, numpy_eight = guidance_for(EIGHT_DIRECTION=direction, OUTER_L=5.0)
    settled_at(guidance, beside(numpy_eight, s, direction * kite_side * 0.03), s)
    along = float(numpy_eight.course(np.array([guidance.path_parameter]))[0])
    assert guidance.cross_track == pytest.approx(-kite_side * 0.03, abs=1e-3)
    turn = wrap(guidance.target_course - along)
    assert turn == pytest.approx(-kite_side * math.atan(5.0 * 0.03), abs=0.04)  # theta grows towards gamma x T
    back = moved(beside(numpy_eight, s, direction * kite_side * 0.03), guidance.target_course, 0.02)
    _, distance = numpy_eight.nearest(back[np.newaxis])
    assert distance[0] < 0.03


def test_a_simple_position_by_hand():
    """The eight's middle is flown upwards and towards +y, so to the right as seen from the ground; a kite higher up
    on the left of that strand is told to go lower, one below it to go higher."""
    guidance, numpy_eight = guidance_for(OUTER_L=5.0)
    middle = numpy_eight.position(np.array([0.0]))[0]
    settled_at(guidance, middle, 0.0)
    assert guidance.cross_track == pytest.approx(0.0, abs=1e-9)
    on_curve = guidance.target_course
    azimuth_rate, elevation_rate = math.radians(30.0) * math.cos(math.radians(40.0)), math.radians(16.0)
    assert on_curve == pytest.approx(math.atan2(-azimuth_rate, elevation_rate), abs=1e-9)  # theta: from up towards -y
    settled_at(guidance, middle + np.array([0.0, -0.02, 0.02]), 0.0)
    assert math.cos(guidance.target_course) < math.cos(on_curve)
    settled_at(guidance, middle + np.array([0.0, 0.02, -0.02]), 0.0)
    assert math.cos(guidance.target_course) > math.cos(on_curve)


@settings(deadline=None, max_examples=200)
@given(flyable(), st.floats(0.0, 2 * math.pi), st.floats(-0.3, 0.3), st.floats(0.0, 50.0))
def test_the_target_is_the_papers(shape, s, offset, gain):
    """cos(theta_t) e1 + sin(theta_t) e2 ~ T + L (t . gamma_t_perp) t, with T the curve's tangent carried to gamma by
    the rotation of gamma_t onto gamma along their geodesic (Rodrigues), and t = gamma x T."""
    guidance, numpy_eight = guidance_for(OUTER_L=gain, **shape)
    gamma = beside(numpy_eight, s, offset)
    settled_at(guidance, gamma, s, steps=30)
    last = guidance.path_parameter
    guidance.at(frame_at(gamma))
    assume(angle_between(last, guidance.path_parameter) < 1e-6)  # not beyond the centre of a turn

    here = np.array([guidance.path_parameter])
    gamma_t, tangent = numpy_eight.position(here)[0], numpy_eight.direction * numpy_eight.derivatives(here)[0][0]
    tangent /= np.linalg.norm(tangent)
    axis = np.cross(gamma_t, gamma)
    sine = np.linalg.norm(axis)
    carried = tangent
    if sine > 1e-9:
        axis, cosine = axis / sine, np.dot(gamma_t, gamma)
        carried = (cosine * tangent + sine * np.cross(axis, tangent)
                   + (1.0 - cosine) * np.dot(axis, tangent) * axis)
    side = np.cross(gamma, carried)
    perpendicular = gamma_t - np.dot(gamma_t, gamma) * gamma
    aim = carried + gain * np.dot(side, perpendicular) * side
    frame = frame_at(gamma)
    up, across = np.array([frame.e1x, frame.e1y, frame.e1z]), np.array([frame.e2x, frame.e2y, 0.0])
    expected = math.atan2(np.dot(aim, across), np.dot(aim, up))
    assert angle_between(guidance.target_course, expected) < 2e-4 * (1.0 + gain)
    distance = float(great_circle_distance(gamma, gamma_t))
    assert guidance.cross_track == pytest.approx(math.copysign(distance, np.dot(side, gamma_t)), abs=1e-6)
    assert -math.pi < guidance.target_course <= math.pi


def test_the_targets_rate_is_its_derivative_smoothed():
    """On the curve it follows the numeric derivative, late by about FF_FILTER; a new strand gives no rate."""
    guidance, numpy_eight = guidance_for(FF_FILTER=0.125)
    s = 0.5
    rates, courses = [], []
    guidance.path_parameter = s
    for _ in range(600):
        guidance.at(frame_at(numpy_eight.position(np.array([s]))[0]))
        rates.append(guidance.target_rate)
        courses.append(guidance.target_course)
        first = numpy_eight.derivatives(np.array([s]))[0][0]
        s += SPEED * PERIOD_S / float(np.linalg.norm(first))
    assert rates[0] == 0.0
    true_rates = wrap_array(np.diff(np.array(courses))) / PERIOD_S
    late = round(0.125 / PERIOD_S)
    assert max(abs(true_rates)) > 2.0
    assert np.array(rates)[100:] == pytest.approx(true_rates[99 - late : -late], abs=0.25)
    guidance.stop()
    assert guidance.target_rate == 0.0
    guidance.at(frame_at(numpy_eight.position(np.array([s + 3.0]))[0]))
    assert guidance.target_rate == 0.0


def test_straight_above_and_straight_behind_give_numbers():
    """The zenith, and the point opposite to the curve's, where the geodesic is not defined."""
    guidance, numpy_eight = guidance_for()
    for position in (np.array([0.0, 0.0, 1.0]), -numpy_eight.position(np.array([0.0]))[0], np.array([-1.0, 0.0, 0.0])):
        settled_at(guidance, position, 0.0)
        assert all(map(math.isfinite, (guidance.target_course, guidance.cross_track, guidance.target_rate)))
        assert 0.0 <= guidance.path_parameter <= 2.0 * math.pi


class Going:
    """A kite that is somewhere, on a course, at SPEED: what the exact step wants to know."""

    def __init__(self, position: np.ndarray, course: float, turning_slew: float = 0.0, **changed: float):
        self.frame, self.course, self.speed = frame_at(position), course, SPEED
        self.turning_ratio, self.turning_slew = 1.0, turning_slew  # per course rate; of the nose [rad/s^2]
        self.config = PredictionConfig()
        self.config.load(parameters(**changed))


@settings(deadline=None, max_examples=100)
@given(flyable(), st.floats(0.0, 2 * math.pi), st.floats(-0.1, 0.1), st.floats(-0.6, 0.6), st.floats(0.0, 10.0))
def test_the_exact_rate_is_how_the_target_turns_past_a_kite_on_its_way(shape, s, offset, astray, gain):
    """Against the target's change between two places a little way apart, with meridian convergence taken out."""
    guidance, numpy_eight = guidance_for(OUTER_L=gain, **shape)
    curvature = max(abs(guidance.curve.geodesic_curvature(at)) for at in np.linspace(0.0, 6.28, 90))
    position = beside(numpy_eight, s, offset / (0.3 * curvature) if curvature > 3.0 else offset)
    settled_at(guidance, position, s, steps=40)
    course = wrap(guidance.target_course + astray)
    step, places = 1e-4, []
    for _ in range(30):
        guidance.exactly_at(Going(position, course))
    rate = guidance.target_rate
    for way in (-step, step):
        place = moved(position, course, way)
        for _ in range(30):
            guidance.exactly_at(Going(place, course))
        places.append((guidance.target_course, math.atan2(place[1], place[0])))
    (before, azimuth), (after, azimuth_after) = places
    turned = wrap(after - before) + position[2] * (azimuth_after - azimuth)
    numeric = turned / (2.0 * step) * SPEED
    assert rate == pytest.approx(numeric, abs=0.05 + 0.02 * abs(numeric))


@settings(deadline=None, max_examples=100)
@given(flyable(), st.floats(0.0, 2 * math.pi), st.floats(0.1, 10.0), st.floats(0.02, 4.0))
def test_a_slow_actuator_begins_early_by_what_it_cannot_turn_in_time(shape, s, rate, full):
    """On the curve: the target's rate is that now, moved towards that ahead by what half the actuator's rate leaves.

    An actuator without a limit, or with one that is fast enough, has the rate of now, to the bit.
    """
    guidance, numpy_eight = guidance_for(**shape)
    position, course = numpy_eight.position(np.array([s]))[0], float(numpy_eight.course(np.array([s]))[0])

    def asked(turning_slew: float, **changed: float) -> float:
        kite = Going(position, course, turning_slew, **changed)
        guidance.stop()
        guidance.path_parameter = s
        guidance.exactly_at(kite)
        return guidance.target_rate

    now = asked(0.0)
    assert asked(1e9, PRED_RATE=rate) == now
    lead = 0.3 / rate
    direction = guidance.curve.direction
    pace = float(np.linalg.norm(numpy_eight.derivatives(np.array([s]))[0][0]))
    way = direction * min(0.8, SPEED * lead / pace)
    curvature = guidance.curve.geodesic_curvature
    change = SPEED * direction * (curvature(s + way) - curvature(s))
    possible = 0.5 * full * rate * lead
    early = math.copysign(max(0.0, abs(change) - possible), change)
    assert asked(full * rate, PRED_RATE=rate) - now == pytest.approx(early, abs=1e-3 + 1e-3 * abs(change))


def test_changing_between_the_ways_to_a_rate_does_not_jump():
    """Exact steps are at the place ahead: the first plain one must not take the way back for a turn."""
    guidance, numpy_eight = guidance_for(FF_FILTER=0.125)
    s, rates = 0.8, []
    for tick in range(300):
        ahead = 0.1 if 100 <= tick < 200 else 0.0
        position = numpy_eight.position(np.array([s + ahead]))[0]
        if ahead:
            guidance.exactly_at(Going(position, float(numpy_eight.course(np.array([s + ahead]))[0])))
        else:
            guidance.at(frame_at(position))
        rates.append(guidance.target_rate)
        s += SPEED * PERIOD_S / float(np.linalg.norm(numpy_eight.derivatives(np.array([s]))[0][0]))
    largest = max(map(abs, rates))
    assert largest < 4.0
    for tick in (100, 200):
        assert abs(rates[tick] - rates[tick - 1]) < 0.25 * largest
    assert max(abs(np.diff(rates[201:]))) < 0.1 * largest
