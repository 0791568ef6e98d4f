"""The control laws in small stories, on the interpreter at hand."""

from math import atan2, cos, pi, sin

from firmware_py import generated_enums as enums
from firmware_py.control.figure_eight import CurveCheck, FigureEight
from firmware_py.control.gains import Gains
from firmware_py.control.guidance import Guidance
from firmware_py.control.steering import Steering
from firmware_py.estimation.estimator import Estimator
from firmware_py.estimation.turn_k_estimate import TurnKEstimate
from firmware_py.parameters import generated_parameters as table
from firmware_py.parameters.values import Parameters
from firmware_py.sphere import TangentFrame, wrap

_POSITION = enums.KITE_VALID_AZIMUTH | enums.KITE_VALID_ELEVATION | enums.KITE_VALID_AIRSPEED


def values_with(*changes):
    """The parameters' values, at their defaults but for pairs of index and value."""
    values = list(Parameters().values)
    for index, value in changes:
        values[index] = value
    return values


def loaded(thing, *changes):
    thing.load(values_with(*changes))
    return thing


def flown(*changes):
    """The gains of these parameters."""
    gains = Gains()
    gains.load(values_with(*changes), TurnKEstimate())
    return gains


def near(value, wanted, tolerance=1e-4):
    return abs(value - wanted) <= tolerance


def sample(time_us, azimuth, elevation, valid=_POSITION, course=0.0):
    return (time_us, azimuth, elevation, 100.0, course, 0.0, 20.0, 0.0, 0.0, valid)


def test_angles_wrap_into_the_half_open_turn():
    for angle, wanted in ((0.0, 0.0), (pi, pi), (-pi, pi), (3 * pi, pi), (1.5 * pi, -0.5 * pi), (-7.0, 2 * pi - 7.0)):
        assert near(wrap(angle), wanted, 1e-5), angle


def test_at_straight_downwind_up_is_z_and_a_quarter_turn_flies_to_minus_y():
    frame = TangentFrame()
    assert near(frame.up(0.0, 0.0, 1.0), 1.0) and near(frame.across(0.0, -1.0), 1.0)
    assert near(frame.distance_to(cos(0.001), sin(0.001), 0.0), 0.001, 1e-7)  # small angles survive


def test_the_eight_crosses_in_its_centre_and_turns_at_its_ends():
    eight = loaded(FigureEight(), (table.EIGHT_HALF_W, 40.0), (table.EIGHT_HALF_H, 10.0))
    first, second = eight.at(0.0), eight.at(pi)
    assert all(near(first[index], second[index]) for index in range(3))
    assert first[4] > 0.0 > second[4] and first[5] > 0.0 and second[5] > 0.0  # up through the middle
    assert abs(eight.geodesic_curvature(0.5 * pi)) > 3.0 > abs(eight.geodesic_curvature(0.0))


def test_a_curve_that_cannot_be_flown_is_refused_in_a_few_calls_with_its_reason():
    for change, says in (
        ((table.EIGHT_HALF_H, 1.0), "deg radius"), ((table.EIGHT_ELEVATION, 15.0), "goes down"),
        ((table.EIGHT_HALF_W, 80.0), "wind window"), ((table.TURN_K, 0.001), "deg radius"),
    ):
        check = CurveCheck()
        check.begin(values_with(change), 100.0)
        for _ in range(30):
            check.advance()
        problem = check.problem or ""
        assert check.done and says in problem and len(problem) <= 50, (change, problem)


def test_beside_the_curve_the_target_points_back_to_it():
    eight = loaded(FigureEight())
    for side in (-0.03, 0.03):
        guidance = Guidance(eight)
        frame = TangentFrame()
        x, y, z, dx, dy, dz = eight.at(0.3)
        size = (dx * dx + dy * dy + dz * dz) ** 0.5
        left = (y * dz - z * dy, z * dx - x * dz, x * dy - y * dx)
        px, py, pz = (p + side * n / size for p, n in zip((x, y, z), left))  # noqa: B905  MicroPython has no strict
        frame.set(atan2(py, px), atan2(pz, (px * px + py * py) ** 0.5))
        guidance.path_parameter = 0.25
        guidance.step(frame, flown((table.OUTER_L, 5.0)), 0.02)
        along = atan2(frame.across(dx, dy), frame.up(dx, dy, dz))
        assert near(guidance.path_parameter, 0.3, 0.01)
        assert near(abs(guidance.cross_track), 0.03, 0.001)
        assert wrap(guidance.target_course - along) * side < 0.0  # off to one side, aim to the other


def test_steering_follows_the_law_and_stays_within_its_limits():
    steering = Steering()
    steering.config.load(values_with((table.STEER_MAX, 0.5)))
    gains = flown((table.INNER_P, 2.0), (table.TURN_K, 0.25))
    kite = Estimator()
    kite.airspeed, kite.course = 20.0, 0.1
    steering.follow(0.6, 0.0, kite, gains, 0.02)
    assert near(steering.asked, 2.0 * 0.5 / (0.25 * 20.0))
    steering.follow(3.0, 0.0, kite, gains, 0.02)
    assert steering.asked == 0.5 and steering.status & enums.KITE_STATUS_SATURATED
    kite.course = 3.0
    steering.follow(-3.0, 0.0, kite, gains, 0.02)  # the short way round
    assert steering.asked > 0.0


def test_streams_that_bring_no_news_are_stale_in_time_and_a_gap_is_seen_by_the_tick_that_ends_it():
    for stream in (
        lambda tick, now: sample(580000, 0.1, 0.5),  # again and again
        lambda tick, now: sample(580000, 0.1 + 0.001 * tick, 0.5),  # a stamp that stands
        lambda tick, now: sample(580000 - tick * 20000, 0.1, 0.5),  # that goes back
        lambda tick, now: sample(now, 0.1 + tick % 2, 0.5),  # jumps
    ):
        kite = Estimator()
        kite.config.load(values_with())
        for tick in range(30):
            kite.wait(20000)
            assert kite.take(sample(tick * 20000, 0.1, 0.5), 0.0, 0.25)
        stale = 0
        for tick in range(1, 3000):
            stale += kite.wait(20000)
            kite.take(stream(tick, (29 + tick) * 20000), 0.0, 0.25)
        assert stale >= 2999 - 27, stale  # the first of a stream may be news
    assert kite.wait(600000)  # the loop stood still
    assert kite.take(sample(100, 0.1, 0.5), 0.0, 0.25) and not kite.is_stale()


def test_the_course_comes_from_positions_and_bad_samples_change_nothing():
    kite = Estimator()
    kite.config.load(values_with())
    for number in range(30):
        kite.wait(20000)
        assert kite.take(sample(number * 20000, -0.004 * number, 0.5), 0.0, 0.25)
    assert near(kite.course, 0.5 * pi, 0.02)
    before = (kite.course, kite.azimuth, kite.elevation)
    now = 30 * 20000
    for bad in (sample(now, float("nan"), 0.5), sample(now, 2.0, 0.5), sample(now - 60000, -0.1, 0.5),
                sample(now, -0.1, 0.5, enums.KITE_VALID_AZIMUTH)):
        kite.wait(20000)
        assert not kite.take(bad, 0.0, 0.25)
    assert kite.dropped == 4 and (kite.course, kite.azimuth, kite.elevation) == before


def test_every_limit_of_every_parameter_holds():
    parameters = Parameters()
    for index in range(table.COUNT):
        default, least, greatest = table.DEFAULTS[index], table.LEASTS[index], table.GREATESTS[index]
        refused = bool(table.FLAGS[index] & table.READ_ONLY)
        for value in (default, least, greatest):
            assert bool(parameters.refusal(index, value, False)) == refused
        for value in (least - 1.0, greatest + 1.0, float("nan"), float("inf")):
            assert parameters.refusal(index, value, False)
