"""The steering actuator against closed forms."""

import math

import pytest

from sim_bridge.equipment.actuator import Actuator
from sim_bridge.equipment.actuator_settings import ActuatorSettings
from sim_bridge.flight.flight import Flight
from sim_bridge.runtimes.inproc import InprocRuntime
from sim_bridge.scenario.scenario import load_scenario


def actuator(**settings):
    return Actuator(ActuatorSettings(**settings))


def after(part, seconds, step=0.01):
    """Position after `seconds`, in steps as a flight takes them."""
    now = 0.0
    while now < seconds - 1e-12:
        part.apply_due(now + 1e-12)
        until = min(seconds, now + step, max(now + 1e-9, part.next_change()))
        part.advance(until - now)
        now = until
    part.apply_due(seconds + 1e-12)
    return part.position


def test_ideal_follows_at_once():
    part = actuator()
    part.command(0.0, 0.7)
    assert after(part, 0.001) == 0.7


def test_dead_time_is_exact():
    part = actuator(dead_time_s=0.5)
    part.command(0.0, 1.0)
    part.apply_due(0.4999)
    assert part.position == 0.0
    part.apply_due(0.5)
    assert part.position == 1.0


def test_saturation_holds_to_both_sides():
    for asked, felt in ((2.0, 0.4), (-2.0, -0.4), (0.39, 0.39)):
        part = actuator(saturation=0.4)
        part.command(0.0, asked)
        assert after(part, 0.1) == felt


def test_rate_limit_is_a_ramp_that_arrives_and_stays():
    part = actuator(rate_limit_per_s=0.2)
    part.command(0.0, 0.3)
    assert after(part, 1.0) == pytest.approx(0.2)
    assert after(part, 1.0) == pytest.approx(0.3)


def test_lag_is_an_exponential_whatever_the_step():
    for step in (0.001, 0.02, 0.5):
        part = actuator(lag_s=0.4)
        part.command(0.0, 1.0)
        assert after(part, 1.0, step) == pytest.approx(1.0 - math.exp(-1.0 / 0.4))


def test_commands_a_few_nanoseconds_apart_do_no_harm_in_flight():
    """By a wall clock they come like that now and then."""
    flight = Flight(load_scenario("small-kite"), InprocRuntime())
    flight.fly(0.5)
    felt = flight.time_s + 0.055
    for nanoseconds in (0, 2, 5, 9, 30):
        flight.actuator.command(felt - 0.05 + nanoseconds * 1e-9, 0.1 + 0.01 * nanoseconds)
    flight.fly(0.7)
    assert len(flight.rows) == 35


def test_lag_behind_a_rate_limit_ramps_first_and_then_settles():
    """Ramp until the error is rate * lag, then an exponential; the sum is exact for any step."""
    for step in (0.001, 0.03, 2.0):
        part = actuator(rate_limit_per_s=0.5, lag_s=0.2)
        part.command(0.0, 1.0)
        ramp_s = (1.0 - 0.1) / 0.5
        assert after(part, 2.3, step) == pytest.approx(1.0 - 0.1 * math.exp(-(2.3 - ramp_s) / 0.2))


def test_the_mean_over_a_step_is_that_of_many_small_ones():
    for changes in ({"rate_limit_per_s": 2.0}, {"lag_s": 0.05}, {"rate_limit_per_s": 2.0, "lag_s": 0.05}):
        part, fine = actuator(**changes), actuator(**changes)
        for each in (part, fine):
            each.command(0.0, 0.5)
            each.apply_due(0.0)
        for dt in (0.1, 0.15, 0.3):  # on the ramp, across its end, and behind it
            positions = []
            for _ in range(1000):
                fine.advance(0.5e-3 * dt)
                positions.append(fine.position)
                fine.advance(0.5e-3 * dt)
            assert part.advance(dt) == pytest.approx(math.fsum(positions) / 1000, abs=1e-6)
