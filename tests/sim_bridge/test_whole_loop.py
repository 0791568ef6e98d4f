"""The whole loop in flight: on a great circle, gain limits and settling are those of the characteristic equation."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from firmware_py.control.figure_eight import CurvePoint, FigureEight
from firmware_py.control.guidance import Guidance
from kite_analysis.delay.characteristic_equation import Gains, Loop
from kite_analysis.delay.characteristic_roots import rightmost_roots
from kite_analysis.delay.inner_loop import loop_delay
from kite_analysis.delay.sampled_loop import SampledLoop, sampled_limit
from kite_analysis.delay.whole_loop import best_gains, gain_limit
from kite_analysis.figure_eight import unit_position
from sim_bridge.flight.flight import Flight
from sim_bridge.flight.start_state import start_position
from sim_bridge.flight.truth_columns import COLUMNS
from sim_bridge.runtimes.inproc import InprocRuntime
from sim_bridge.scenario.scenario import load_scenario

HZ = 50.0


class GreatCircle(FigureEight):
    """A target through the unit position `start` in the unit direction `along`, in the place of the eight."""

    def __init__(self, start, along):
        super().__init__()
        self.half_width = math.pi  # a kite is never lost
        self._start, self._along = start, along

    def at(self, s):
        """Position and derivative at `s` [rad], as FigureEight gives them."""
        cosine, sine = math.cos(s), math.sin(s)
        position = (cosine * a + sine * b for a, b in zip(self._start, self._along, strict=True))
        derivative = (cosine * b - sine * a for a, b in zip(self._start, self._along, strict=True))
        return (*position, *derivative)


class GreatCirclePoint(CurvePoint):
    """A point that goes along it."""

    def go_to(self, s):
        """Go to `s` [rad]."""
        self.x, self.y, self.z, self.dx, self.dy, self.dz = self._curve.at(s)
        self.square = self.pace = 1.0

    def geodesic_curvature(self):
        """It has none."""
        return 0.0


class Case(NamedTuple):
    """Dead time [s], speed over length [1/s], outer gain, the actuator's time constant [s]."""

    delay_s: float
    speed: float
    outer_l: float
    lag_s: float = 0.0

    @property
    def loop(self):
        return Loop(loop_delay(self.delay_s, HZ), self.speed, self.lag_s)

    @property
    def sampled(self):
        return SampledLoop(self.delay_s, HZ, self.speed, self.lag_s)


def flight_errors(case, gain, duration_s, course_error_rad=0.003):
    """Times [s] and cross-track errors [rad] of a flight along a great circle, begun with a small course error."""
    scenario = load_scenario("paper-delay")
    flight = Flight(scenario, InprocRuntime())
    start, along = start_position(scenario.start, flight.eight)
    for key, value in (("link.control.delay_s", case.delay_s), ("plant.speed_over_length", case.speed),
                       ("actuator.lag_s", case.lag_s), ("start.course_error_rad", course_error_rad)):
        scenario.set(key, value, "test")
    for name, value in (("INNER_P", gain), ("OUTER_L", case.outer_l), ("FF_GAIN", 0.0), ("PARK_ELEVATION", 0.0)):
        scenario.set_parameter(name, value, "test")
    runtime = InprocRuntime()
    curve = GreatCircle(start, along)
    guidance = runtime.autopilot.guidance = Guidance(curve)
    guidance._point = GreatCirclePoint(curve)
    flight = Flight(scenario, runtime)
    flight.fly(duration_s)
    columns = dict(zip(COLUMNS, np.array(flight.rows).T, strict=True))
    side = np.cross(start, along)
    positions = unit_position(columns["azimuth_rad"], columns["elevation_rad"])
    return columns["time_s"], np.arcsin(positions @ side)


def growth_of_swing(times, errors, frequency, from_s):
    """Rate at which the swing at about `frequency` [rad/s] grows [1/s], from `from_s` [s] on.

    Three values a quarter of a swing apart foretell the fourth where a swing and one slow error are left (Prony); the
    roots of that rule are the factors by which they grow in that time.
    """
    lag = max(1, round(0.5 * math.pi / frequency * HZ))
    late = errors[times >= from_s]
    past = np.stack([late[2 * lag : -lag], late[lag : -2 * lag], late[: -3 * lag]], axis=1)
    rule, *_ = np.linalg.lstsq(past, late[3 * lag :], rcond=None)
    factors = np.roots([1.0, *-rule])
    swing = factors[np.abs(factors.imag) > 1e-3 * np.abs(factors)]
    return float(np.log(np.abs(swing)).max()) * HZ / lag


def settling_rate(times, errors, expected, from_s, to_s):
    """Rate r [1/s] for which (a + b t + c t^2) exp(-r t) fits best: three roots in one.

    The envelope's own slope comes near to r only as 2 / t. Errors are weighted against the decay: late ones count too.
    """
    part = (times >= from_s) & (times <= to_s)
    t, wanted = times[part] - from_s, errors[part] * np.exp(expected * (times[part] - from_s))

    def misfit(rate):
        shapes = np.exp((expected - rate) * t)[:, None] * t[:, None] ** np.arange(3)
        weights, *_ = np.linalg.lstsq(shapes, wanted, rcond=None)
        return np.linalg.norm(shapes @ weights - wanted)

    rates = expected * np.linspace(0.5, 1.7, 241)
    return float(rates[int(np.argmin([misfit(rate) for rate in rates]))])


CASES = [
    Case(0.1, 0.06, 5.0), Case(0.1, 0.2, 2.0), Case(0.1, 0.45, 5.0), Case(0.2, 0.06, 2.0), Case(0.2, 0.2, 5.0),
    Case(0.2, 0.45, 5.0), Case(0.4, 0.06, 5.0), Case(0.4, 0.2, 5.0), Case(0.4, 0.45, 5.0), Case(0.5, 0.06, 4.0),
    Case(0.2, 0.8, 2.0), Case(0.2, 0.45, 3.0, lag_s=0.1), Case(0.1, 0.2, 4.0, lag_s=0.3),
]


@pytest.mark.parametrize("case", CASES)
def test_the_flown_loop_turns_unstable_where_the_design_says(case):
    """Within 3 % of the half period's limit, and within 0.5 % of the exactly sampled one; by bisection."""
    predicted = gain_limit(case.loop, case.outer_l)
    frequency = abs(rightmost_roots(case.loop, Gains(predicted, case.outer_l), 2)[0].imag)
    duration_s = max(6.0, 2.0 + 6.0 * math.pi / frequency)

    def growth(gain):
        times, errors = flight_errors(case, gain, duration_s)
        return growth_of_swing(times, errors, frequency, max(2.0, duration_s / 3.0))

    low, high = 0.92 * predicted, 1.08 * predicted
    assert growth(low) < 0.0 < growth(high)
    while high - low > 0.006 * predicted:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if growth(middle) < 0.0 else (low, middle)
    flown = 0.5 * (low + high)
    assert flown == pytest.approx(predicted, rel=0.03)
    assert flown == pytest.approx(sampled_limit(case.sampled, case.outer_l), rel=0.005)


@pytest.mark.parametrize(("case", "gain", "duration_s"), [
    (Case(0.4, 0.45, 5.0), 0.5, 12.0),  # stable in the plane, where the limit is 0.537; the sphere makes it 0.457
    # Beyond the greatest outer gain, 4.28 here, no inner gain holds.
    (Case(0.5, 0.45, 5.0), 0.1, 20.0), (Case(0.5, 0.45, 5.0), 0.5, 14.0), (Case(0.5, 0.45, 5.0), 2.0, 8.0),
])
def test_errors_grow_as_fast_as_said(case, gain, duration_s):
    root = rightmost_roots(case.loop, Gains(gain, case.outer_l), 2)[0]
    assert gain_limit(case.loop, case.outer_l) < gain
    times, errors = flight_errors(case, gain, duration_s, course_error_rad=1e-4)
    measured = growth_of_swing(times, errors, abs(root.imag), duration_s / 4.0)
    assert measured > 0.0 and measured == pytest.approx(root.real, rel=0.01, abs=2e-4)


@pytest.mark.parametrize(("delay_s", "speed", "lag_s"), [
    (0.2, 0.45, 0.0), (0.5, 0.06, 0.0), (0.2, 0.2, 0.0), (0.4, 0.45, 0.0), (0.1, 0.45, 0.0), (0.2, 0.45, 0.1)])
def test_the_best_pair_settles_as_fast_as_said(delay_s, speed, lag_s):
    """Measured from 2 to 7 of its own time constants: further on, single precision shows."""
    gains, rate = best_gains(Case(delay_s, speed, 0.0, lag_s).loop)
    case = Case(delay_s, speed, gains.outer_l, lag_s)
    times, errors = flight_errors(case, gains.inner_p, 8.0 / -rate, course_error_rad=0.02)
    measured = settling_rate(times, errors, -rate, 2.0 / -rate, 7.0 / -rate)
    assert measured == pytest.approx(-rate, rel=0.05)


@pytest.mark.parametrize(("p_share", "l_share"), [(0.7, 1.0), (1.0, 1.5), (1.0, 2.5), (1.4, 2.0)])
def test_other_pairs_settle_more_slowly_as_said(p_share, l_share):
    gains, best = best_gains(Case(0.2, 0.45, 0.0).loop)
    case = Case(0.2, 0.45, l_share * gains.outer_l)
    root = rightmost_roots(case.loop, Gains(p_share * gains.inner_p, case.outer_l), 2)[0]
    assert abs(root.imag) > 0.5
    times, errors = flight_errors(case, p_share * gains.inner_p, 5.0, course_error_rad=0.02)
    measured = growth_of_swing(times, errors, max(abs(root.imag), 3.0), 0.8)
    assert measured == pytest.approx(root.real, rel=0.05)
    assert measured > 0.95 * best
