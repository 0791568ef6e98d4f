"""Each error of a sensor, alone, in samples of a kite that hovers and of one that flies.

Bounds of statistics are 4.5 standard deviations of what is estimated.
"""

import math

import numpy as np
import pytest

from protocol import dialect
from sim_bridge.equipment.error_processes import Dropouts, Wander
from sim_bridge.equipment.error_settings import NO_ERRORS, QUANTITIES, ErrorSettings, MeasurementErrors
from sim_bridge.equipment.sensor_settings import SensorSettings
from tests.sim_bridge.measured import PERIOD_S, column, error, flying, hovering, measured, only
from tests.sim_bridge.measured import QUANTITIES as MEASURED

SIGMAS = 4.5
FELT = {"position": ("azimuth", "elevation")}  # a section's quantities, where they are not of its own name
BITS = {
    "position": dialect.KITE_VALID_AZIMUTH | dialect.KITE_VALID_ELEVATION, "course": dialect.KITE_VALID_COURSE,
    "heading": dialect.KITE_VALID_HEADING, "distance": dialect.KITE_VALID_DISTANCE,
    "airspeed": dialect.KITE_VALID_AIRSPEED, "tether_force": dialect.KITE_VALID_TETHER_FORCE,
    "steering": dialect.KITE_VALID_STEERING,
}
ALL_BITS = sum(BITS.values())
LATE = ErrorSettings(lag_s=0.033)
EVERYTHING = ErrorSettings(noise=0.01, wander=0.02, bias=0.1, scale=1.1, lag_s=0.13, dropout=0.2, dropout_s=0.3)
ALL = MeasurementErrors(*[EVERYTHING] * len(QUANTITIES))


def about(section: str) -> tuple[str, ...]:
    """The quantities that a section is about."""
    return FELT.get(section, (section,))


@pytest.mark.parametrize("section", QUANTITIES)
@pytest.mark.parametrize("moments", [hovering(20.0), flying()], ids=["hovering", "flying"])
def test_an_error_is_felt_in_its_own_quantity_and_nothing_else_not_even_the_stamp(section, moments):
    exact, wrong = measured(moments), measured(moments, only(section, EVERYTHING))
    for quantity in ("time_us", *MEASURED):
        same = np.array_equal(column(exact, quantity), column(wrong, quantity))
        assert same is (quantity not in about(section)), quantity
    cleared = column(exact, "valid") & ~column(wrong, "valid")
    assert set(cleared) == {0, BITS[section]}
    assert set(column(exact, "valid")) == {ALL_BITS}


@pytest.mark.parametrize("quantity", MEASURED)
def test_white_noise_has_its_deviation_no_mean_and_no_memory(quantity):
    moments = hovering(200.0)
    section = "position" if quantity in FELT["position"] else quantity
    noise = error(moments, quantity, only(section, ErrorSettings(noise=0.05))) / 0.05
    bound = SIGMAS / math.sqrt(len(noise))
    assert abs(np.mean(noise)) < bound
    assert abs(np.mean(noise**2) - 1.0) < bound * math.sqrt(2.0)
    assert abs(np.mean(noise[1:] * noise[:-1])) < bound


def test_azimuth_and_elevation_draw_each_for_itself():
    random = only("position", ErrorSettings(noise=0.05, wander=0.1, wander_time_s=0.1))
    of = {quantity: error(hovering(200.0), quantity, random) for quantity in FELT["position"]}
    n = len(of["azimuth"]) / 10  # the wander's memory leaves fewer that are independent
    assert abs(np.corrcoef(of["azimuth"], of["elevation"])[0, 1]) < SIGMAS / math.sqrt(n)


def test_wander_and_noise_of_a_quantity_have_nothing_in_common():
    wander = error(hovering(200.0), "heading", only("heading", ErrorSettings(wander=0.1, wander_time_s=0.01)))
    noise = error(hovering(200.0), "heading", only("heading", ErrorSettings(noise=0.1)))
    assert abs(np.corrcoef(wander, noise)[0, 1]) < SIGMAS / math.sqrt(len(noise))


@pytest.mark.parametrize("moments", [hovering(20.0), flying()], ids=["hovering", "flying"])
def test_wander_is_slow_and_its_steps_are_as_large_as_deviation_and_time_make_them(moments):
    steps = np.diff(error(moments, "heading", only("heading", ErrorSettings(wander=0.1, wander_time_s=5.0))))
    expected = 0.1 * math.sqrt(2.0 * (1.0 - math.exp(-PERIOD_S / 5.0)))
    assert np.std(steps) / expected == pytest.approx(1.0, abs=SIGMAS / math.sqrt(2.0 * len(steps)))


def test_wander_is_stationary_from_the_start_and_forgets_exactly_however_often_it_is_asked():
    n, bound = 4000, SIGMAS / math.sqrt(4000)
    for times in ((0.0, 3.0), (0.0, 0.01, 0.5, 2.9, 3.0)):
        ways = np.array([[wander.at(time_s) for time_s in times]
                         for wander in (Wander(1.0, 3.0, f"{seed}") for seed in range(n))])
        first, last = ways[:, 0], ways[:, -1]
        for values in (first, last):
            assert abs(np.mean(values)) < bound and abs(np.mean(values**2) - 1.0) < bound * math.sqrt(2.0)
        assert abs(np.mean(first * last) - math.exp(-1.0)) < bound * math.sqrt(1.0 + math.exp(-2.0))


@pytest.mark.parametrize("moments", [hovering(2.0), flying()], ids=["hovering", "flying"])
def test_bias_and_scale_are_exact_and_the_scale_comes_first(moments):
    wrong = ErrorSettings(scale=0.8, bias=2.0)
    for quantity, section in (("airspeed", "airspeed"), ("tether_force", "tether_force"), ("distance", "distance")):
        exact = column(measured(moments), quantity)
        assert column(measured(moments, only(section, wrong)), quantity) == pytest.approx(0.8 * exact + 2.0, rel=1e-6)
    turned = error(moments, "course", only("course", ErrorSettings(bias=0.3)))
    assert turned == pytest.approx(np.full(len(turned), 0.3), abs=1e-6)


def test_angles_stay_within_half_a_turn_and_an_airspeed_is_never_negative():
    turned = column(measured(flying(), only("course", ErrorSettings(bias=1.5))), "course")
    assert -math.pi - 1e-6 <= turned.min() < -3.0 and 3.0 < turned.max() <= math.pi + 1e-6
    slow = column(measured(hovering(2.0), only("airspeed", ErrorSettings(bias=-12.0, noise=1.0))), "airspeed")
    assert slow.min() == 0.0 < slow.max()


@pytest.mark.parametrize("quantity", MEASURED)
@pytest.mark.parametrize("ticks", [1, 7, 50])
def test_a_lag_of_whole_ticks_gives_what_was_true_then_with_the_stamp_of_now(quantity, ticks):
    section = "position" if quantity in FELT["position"] else quantity
    exact, late = measured(flying()), measured(flying(), only(section, ErrorSettings(lag_s=ticks * PERIOD_S)))
    was, reads = column(exact, quantity), column(late, quantity)
    assert reads[ticks:] == pytest.approx(was[:-ticks], abs=1e-6)
    assert list(reads[:ticks]) == [reads[0]] * ticks  # the past before the first tick is as it was then
    assert np.array_equal(column(exact, "time_us"), column(late, "time_us"))


@pytest.mark.parametrize("rate_hz", [0.0, 10.0, 37.0])
def test_a_lag_between_ticks_is_interpolated_between_ticks_at_any_rate_of_samples(rate_hz):
    settings = SensorSettings(rate_hz=rate_hz)
    late = measured(flying(), MeasurementErrors(distance=LATE, course=LATE), settings)
    time_s = column(late, "time_us") * 1e-6
    ticks_s = np.array([moment.time_s for moment in flying()])
    start_s = time_s[0] - ticks_s[0]
    for quantity in ("distance", "course"):
        truth = np.array([getattr(moment.truth, quantity) for moment in flying()])
        truth = np.unwrap(truth) if quantity == "course" else truth  # the short way round, where the course leaps
        was = np.interp(time_s - start_s - 0.033, ticks_s, truth)
        reads = column(late, quantity)
        apart = np.remainder(reads - was + math.pi, math.tau) - math.pi
        assert np.max(np.abs(apart)) < 1e-5
    leaps = np.abs(np.diff(np.array([moment.truth.course for moment in flying()]))) > math.pi
    assert leaps.sum() > 2


def test_lag_comes_before_scale_and_bias():
    exact = column(measured(flying()), "airspeed")
    late = column(measured(flying(), only("airspeed", ErrorSettings(lag_s=0.2, scale=1.5, bias=3.0))), "airspeed")
    assert late[10:] == pytest.approx(1.5 * exact[:-10] + 3.0, rel=1e-6)


def test_resolution_comes_last():
    wrong = only("position", ErrorSettings(noise=0.01, wander=0.05, bias=0.002))
    noisy = column(measured(flying(), wrong, SensorSettings(resolution_rad=0.01)), "elevation")
    assert np.max(np.abs(noisy / 0.01 - np.round(noisy / 0.01))) < 1e-4


def runs(missing: np.ndarray) -> np.ndarray:
    """Lengths of the dropouts [samples], without those that the ends cut."""
    changes = np.flatnonzero(np.diff(missing.astype(int)))
    lengths = np.diff(changes)
    return lengths[0 if not missing[0] else 1 :: 2]


@pytest.mark.parametrize("section", QUANTITIES)
@pytest.mark.parametrize(("fraction", "length_s"), [(0.2, 0.0), (0.1, 0.2), (0.5, 0.3)])
def test_dropouts_have_their_fraction_and_their_mean_length(section, fraction, length_s):
    samples = measured(hovering(400.0), only(section, ErrorSettings(dropout=fraction, dropout_s=length_s)))
    missing = (column(samples, "valid") & BITS[section]) == 0
    keep = math.exp(-PERIOD_S / (length_s * (1.0 - fraction))) if length_s else 0.0
    n = len(missing) * (1.0 - keep) / (1.0 + keep)  # as many independent samples say as much about the mean
    assert abs(np.mean(missing) - fraction) < SIGMAS * math.sqrt(fraction * (1.0 - fraction) / n)
    found = runs(missing)
    mean = 1.0 / ((1.0 - fraction) * (1.0 - keep))  # in samples; shorter dropouts fall between two of them
    assert abs(np.mean(found) - mean) < SIGMAS * math.sqrt(mean * (mean - 1.0) / len(found))
    if length_s:
        assert length_s < mean * PERIOD_S < length_s + 1.5 * PERIOD_S


def test_dropouts_are_as_long_at_any_rate_and_a_fraction_of_1_leaves_nothing():
    times = {rate_hz: np.arange(0.0, 2000.0, 1.0 / rate_hz) for rate_hz in (10.0, 50.0)}
    for rate_hz, at in times.items():
        dropouts = Dropouts(0.25, 2.0, "seed")
        found = runs(np.array([dropouts.missing_at(float(time_s)) for time_s in at])) / rate_hz
        assert abs(np.mean(found) - 2.0) < SIGMAS * 2.0 / math.sqrt(len(found)) + 0.5 / rate_hz
    assert set(column(measured(hovering(2.0), only("heading", ErrorSettings(dropout=1.0, dropout_s=3.0))), "valid")
               & BITS["heading"]) == {0}


def test_a_quantity_that_is_not_measured_stays_so_whatever_its_errors():
    valid = column(measured(hovering(4.0), only("heading", EVERYTHING), SensorSettings(heading=False)), "valid")
    assert set(valid) == {ALL_BITS & ~BITS["heading"]}


def test_the_same_seed_gives_the_same_samples_and_another_gives_others():
    assert measured(flying(), ALL) == measured(flying(), ALL)
    one, other = measured(flying(), ALL, seed=1), measured(flying(), ALL, seed=2)
    assert all((column(one, quantity) != column(other, quantity)).any() for quantity in (*MEASURED, "valid"))


@pytest.mark.parametrize("section", QUANTITIES)
def test_an_error_more_moves_nobody_elses_chance(section):
    """Neither that of other quantities, nor of the sensors' own noise, nor of the same quantity's other errors."""
    settings = SensorSettings(noise_rad=0.01, course_noise_rad=0.02, airspeed_noise=0.03)
    without = measured(flying(), ALL._replace(**{section: NO_ERRORS}), settings)
    with_it = measured(flying(), ALL, settings)
    for quantity in MEASURED:
        if quantity not in about(section):
            assert np.array_equal(column(without, quantity), column(with_it, quantity)), quantity
    noise, wander = ErrorSettings(noise=0.02), ErrorSettings(wander=0.05)
    together = ErrorSettings(noise=0.02, wander=0.05, dropout=0.3)
    for quantity in about(section):
        alone = [error(hovering(4.0), quantity, only(section, each)) for each in (noise, wander)]
        summed = error(hovering(4.0), quantity, only(section, together))
        assert summed == pytest.approx(alone[0] + alone[1], abs=2e-4)


def test_no_errors_are_no_work():
    assert not MeasurementErrors().any() and MeasurementErrors(heading=ErrorSettings(bias=0.1)).any()
