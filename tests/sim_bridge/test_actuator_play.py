"""Dead band and backlash of the actuator: stories, and an independent integration in small steps."""

import copy
import math
from typing import Any, NamedTuple

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from sim_bridge.equipment.actuator import Actuator
from sim_bridge.equipment.actuator_settings import ActuatorSettings

FINE_S = 2e-4
STEP_S = 0.02


def mean_over(part, dt):
    """Mean position over the next `dt` [s], of an actuator that stays as it is."""
    return copy.copy(part).advance(dt)


def position_after(part, dt):
    """Position `dt` [s] on, of an actuator that stays as it is."""
    there = copy.copy(part)
    there.advance(dt)
    return there.position


def sent_to(part: Actuator, steering: float, seconds: float = 5.0) -> tuple[float, float]:
    """Motor and steering some time after a command."""
    part.command(0.0, steering)
    part.apply_due(0.0)
    part.advance(seconds)
    return part.motor, part.position


@pytest.mark.parametrize("changes", [{}, {"rate_limit_per_s": 0.5}, {"lag_s": 0.1},
                                     {"rate_limit_per_s": 0.5, "lag_s": 0.1}])
def test_steering_follows_the_motor_at_half_the_play_and_waits_for_all_of_it_after_a_reversal(changes):
    part = Actuator(ActuatorSettings(backlash=0.1, **changes))
    for asked, felt in ((0.3, 0.25), (0.25, 0.25), (0.21, 0.25), (0.1, 0.15), (-0.3, -0.25), (-0.22, -0.25)):
        assert sent_to(part, asked) == pytest.approx((asked, felt))


def test_after_a_reversal_the_steering_waits_until_the_motor_has_crossed_the_play():
    part = Actuator(ActuatorSettings(backlash=0.1, rate_limit_per_s=0.5))
    sent_to(part, 0.3)
    part.command(0.0, -0.3)
    part.apply_due(0.0)
    assert mean_over(part, 0.2) == pytest.approx(0.25)  # 0.1 at 0.5 per second
    assert mean_over(part, 0.6) == pytest.approx(0.25 - 0.5 * 0.4**2 / 2 / 0.6)
    assert position_after(part, 0.6) == pytest.approx(0.05)


def test_a_lag_takes_up_the_play_along_its_exponential():
    part = Actuator(ActuatorSettings(backlash=0.2, lag_s=0.5))
    part.command(0.0, 1.0)
    part.apply_due(0.0)
    taken_up_s = 0.5 * math.log(1.0 / 0.9)
    assert position_after(part, 0.99 * taken_up_s) == 0.0
    assert position_after(part, taken_up_s + 0.3) == pytest.approx(0.9 * (1.0 - math.exp(-0.3 / 0.5)))


def test_a_motor_at_rest_leaves_commands_within_its_dead_band_alone_and_goes_all_the_way_for_others():
    part = Actuator(ActuatorSettings(dead_band=0.1, rate_limit_per_s=0.5))
    for asked, reached in ((0.09, 0.0), (0.11, 0.11), (0.02, 0.11), (0.2, 0.11), (0.22, 0.22), (0.0, 0.0)):
        assert sent_to(part, asked)[0] == pytest.approx(reached, abs=1e-6)


def test_a_motor_on_its_way_takes_any_command():
    part = Actuator(ActuatorSettings(dead_band=0.1, rate_limit_per_s=0.5))
    sent_to(part, 0.3, seconds=0.2)
    assert sent_to(part, 0.11)[0] == pytest.approx(0.11, abs=1e-6)


def test_a_motor_with_a_lag_comes_to_rest_a_twentieth_of_the_dead_band_from_the_command():
    part = Actuator(ActuatorSettings(dead_band=0.1, lag_s=0.1))
    assert sent_to(part, 0.5)[0] == pytest.approx(0.495)
    assert sent_to(part, 0.59)[0] == pytest.approx(0.495)
    assert sent_to(part, 0.6)[0] == pytest.approx(0.595)


def test_a_motor_that_stops_before_it_has_taken_up_the_play_leaves_the_steering_where_it_is():
    part = Actuator(ActuatorSettings(dead_band=0.4, backlash=0.97, lag_s=0.1))  # it stops at 0.48, the play at 0.485
    part.command(0.0, 0.5)
    part.apply_due(0.0)
    assert mean_over(part, 20.0) == position_after(part, 20.0) == 0.0


def test_an_ideal_actuator_has_play_and_dead_band_too():
    part = Actuator(ActuatorSettings(dead_band=0.1, backlash=0.04))
    for asked, felt in ((0.2, 0.18), (0.25, 0.18), (0.05, 0.07)):
        part.command(0.0, asked)
        part.apply_due(0.0)
        assert part.position == pytest.approx(felt) == mean_over(part, 0.01)


def test_the_greatest_steering_is_half_the_play_short_of_saturation():
    for changes, reach in (({"saturation": 0.4}, 0.4), ({"saturation": 0.4, "backlash": 0.1}, 0.35),
                           ({"saturation": 0.1, "backlash": 0.3}, 0.0), ({"backlash": 0.1}, math.inf)):
        setting = ActuatorSettings(rate_limit_per_s=1.0, **changes)
        assert setting.reach == pytest.approx(reach)
        if setting.saturation:
            assert sent_to(Actuator(setting), -1.0)[1] == pytest.approx(-reach)


class Integrated:
    """An actuator by its equations, in steps of FINE_S; `close` says how close a decision was."""

    def __init__(self, setting: ActuatorSettings):
        self._setting = setting
        self._goal = self.motor = self.steering = 0.0
        self._running = False
        self.close = math.inf

    def command(self, asked: float) -> None:
        setting = self._setting
        goal = max(-setting.saturation, min(setting.saturation, asked)) if setting.saturation else asked
        difference = abs(goal - self.motor)
        if not self._running:
            self.close = min(self.close, abs(difference - setting.dead_band) if setting.dead_band else math.inf)
        elif setting.dead_band:
            self.close = min(self.close, abs(abs(self._goal - self.motor) - self._arrived()))
        if self._running or difference >= setting.dead_band:
            self._goal, self._running = goal, True

    def fly(self, seconds: float) -> float:
        """Go on, and return the mean of the steering."""
        steps = max(1, round(seconds / FINE_S))
        step_s, total = seconds / steps, 0.0
        for _ in range(steps):
            before = self.steering
            self._step(step_s)
            total += 0.5 * (before + self.steering)
        return total / steps

    def _step(self, step_s: float) -> None:
        if self._running:
            half = self.motor + 0.5 * step_s * self._speed(self.motor)
            moved = self.motor + step_s * self._speed(half)
            past = (self._goal - moved) * (self._goal - self.motor) <= 0.0
            self.motor = self._goal if past else moved
            if abs(self._goal - self.motor) <= self._arrived():
                self._running = self._setting.dead_band == 0.0
        play = 0.5 * self._setting.backlash
        if self.motor - self.steering > play:
            self.steering = self.motor - play
        elif self.steering - self.motor > play:
            self.steering = self.motor + play

    def _speed(self, motor: float) -> float:
        error, rate, lag = self._goal - motor, self._setting.rate_limit_per_s, self._setting.lag_s
        speed = abs(error) / lag if lag else math.inf
        return math.copysign(min(speed, rate or math.inf), error) if error else 0.0

    def _arrived(self) -> float:
        return 0.05 * self._setting.dead_band if self._setting.lag_s else 0.0


class Told(NamedTuple):
    """A command, and how long it is until the next."""

    steering: float
    seconds: float


SETTINGS = st.builds(
    ActuatorSettings, rate_limit_per_s=st.sampled_from([0.0, 0.21, 1.0, 4.0]), lag_s=st.sampled_from([0.0, 0.05, 0.3]),
    saturation=st.sampled_from([0.0, 0.4]), dead_band=st.one_of(st.just(0.0), st.floats(0.005, 0.3)),
    backlash=st.one_of(st.just(0.0), st.floats(0.005, 0.5)),
).filter(lambda setting: setting.rate_limit_per_s or setting.lag_s)
COMMANDS = st.lists(st.builds(Told, st.floats(-1.0, 1.0), st.floats(0.01, 0.5)), min_size=1, max_size=6)


@settings(max_examples=150, deadline=None)
@given(SETTINGS, COMMANDS)
def test_any_actuator_moves_as_its_equations_integrated_in_small_steps(setting: Any, commands: Any):
    exact, fine = Actuator(setting), Integrated(setting)
    for told in commands:
        exact.command(0.0, told.steering)
        exact.apply_due(0.0)
        fine.command(told.steering)
        assume(fine.close > 2e-3)  # both decide alike whether the motor starts
        left = told.seconds
        while left > 1e-9:
            step_s = min(STEP_S, left)
            mean, end = mean_over(exact, step_s), position_after(exact, step_s)
            exact.advance(step_s)
            left -= step_s
            assert fine.fly(step_s) == pytest.approx(mean, abs=1.5e-3)
            assert fine.steering == pytest.approx(end, abs=1.5e-3) == exact.position
            assert fine.motor == pytest.approx(exact.motor, abs=1.5e-3)


@settings(max_examples=150, deadline=None)
@given(SETTINGS, COMMANDS, st.integers(1, 7))
def test_one_long_step_is_many_short_ones_exactly(setting: Any, commands: Any, parts: int):
    whole, split = Actuator(setting), Actuator(setting)
    for told in commands:
        for actuator in (whole, split):
            actuator.command(0.0, told.steering)
            actuator.apply_due(0.0)
        means = []
        for _ in range(parts):
            means.append(mean_over(split, told.seconds / parts))
            split.advance(told.seconds / parts)
        assert mean_over(whole, told.seconds) == pytest.approx(math.fsum(means) / parts, abs=1e-9)
        whole.advance(told.seconds)
        assert (whole.motor, whole.position) == pytest.approx((split.motor, split.position), abs=1e-9)
