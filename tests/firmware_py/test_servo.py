"""The steering servo: every pulse lies within its end points, and it is neutral whenever it must be."""

import math

import pytest
from simulated_hardware import CoarsePwm, SimulatedPwm

from firmware_py.drivers.servo import Servo

SERVOS = {"plain": (1000, 1500, 2000), "turned round": (2100, 1400, 900), "lopsided": (1490, 1500, 2500)}
NEXT_TO_ONE = (math.nextafter(1.0, 0.0), 1.0, math.nextafter(1.0, 2.0))


def made(pulses=SERVOS["plain"]):
    pwm = SimulatedPwm()
    return Servo(pwm, *pulses), pwm


@pytest.mark.parametrize("pulses", SERVOS.values(), ids=SERVOS)
def test_end_points_are_reached_and_never_passed(pulses):
    servo, pwm = made(pulses)
    minus, neutral, plus = pulses
    for size in (*NEXT_TO_ONE, 1.5, 1e9, 3.4e38, math.inf):
        for steering, end in ((size, plus), (-size, minus)):
            servo.write(0.0, True)
            servo.write(steering, True)
            assert pwm.pulses[-2:] == [neutral, end]
    for step in range(-1100, 1101):
        servo.write(step / 1000, True)
    assert min(pulses) == min(pwm.pulses) and max(pulses) == max(pwm.pulses)


@pytest.mark.parametrize("pulses", SERVOS.values(), ids=SERVOS)
def test_pulses_follow_the_steering_on_each_side(pulses):
    servo, pwm = made(pulses)
    minus, neutral, plus = pulses
    for steering in (0.25, 0.5, 0.75):
        servo.write(steering, True)
        assert pwm.pulses[-1] == pytest.approx(neutral + steering * (plus - neutral), abs=0.51)
        servo.write(-steering, True)
        assert pwm.pulses[-1] == pytest.approx(neutral + steering * (minus - neutral), abs=0.51)


def test_half_a_microsecond_to_either_side_of_neutral():
    servo, pwm = made()
    for steering, pulse in ((0.000999, 1500), (0.001001, 1501), (-0.000999, 1500), (-0.001001, 1499), (0.0, 1500)):
        servo.write(steering, True)
        assert pwm.pulses[-1] == pulse


def test_neutral_from_the_first_moment_when_disarmed_and_for_what_is_no_number():
    servo, pwm = made()
    assert pwm.pulses == [1500]
    for steering, armed in ((1.0, False), (-0.3, False), (math.nan, True), (math.nan, False), (math.inf, False)):
        servo.write(1.0, True)
        servo.write(steering, armed)
        assert pwm.pulses[-2:] == [2000, 1500]


def test_the_output_is_only_touched_when_the_pulse_changes():
    servo, pwm = made()
    for _ in range(5):
        servo.write(0.5, True)
    assert pwm.pulses == [1500, 1750]


def test_a_pwm_that_only_knows_shares_of_its_period():
    pwm = CoarsePwm()
    servo = Servo(pwm, 1000, 1500, 2000)
    for steering, pulse in ((1.0, 2000), (-1.0, 1000), (0.5, 1750)):
        servo.write(steering, True)
        assert pulse - 0.4 < pwm.pulses[-1] <= pulse
