"""The stepping of springs and masses, against what can be worked out on paper."""

import math

import numpy as np
import pytest

from sim_bridge.plants.particles import GROUND, ParticleSystem, Spring

G = 9.81


def weight(masses):
    def forces(_x, _v, out):
        out[:, 2] -= G * masses
    return forces


def pendulum(stiffness, angle=0.3, length=2.0):
    damping = 0.03 * 2.0 * math.sqrt(1.5 * stiffness)  # 3 % of the critical one
    masses = np.array([1.5])
    position = length * np.array([[math.sin(angle), 0.0, -math.cos(angle)]])
    return ParticleSystem(position, np.zeros((1, 3)), masses, [Spring(0, GROUND, length, stiffness, damping)]), masses


def angle_after(seconds, step, stiffness):
    system, masses = pendulum(stiffness)
    for _ in range(round(seconds / step)):
        system.step(step, weight(masses))
    return math.atan2(system.x[0, 0], -system.x[0, 2])


def test_a_soft_pendulum_converges_with_the_square_of_the_step():
    fine = angle_after(1.0, 1e-4, 500.0)
    errors = [abs(angle_after(1.0, step, 500.0) - fine) for step in (0.008, 0.004)]
    assert 3.0 < errors[0] / errors[1] < 5.0


def test_a_stiff_line_is_stepped_over_not_followed():
    # At 5e5 N/m the line rings at 92 Hz: h w = 2.9 for steps of 5 ms, more than any explicit method of second order
    # bears. The swing has its period of 2 pi sqrt(l/g) (1 + a^2/16 + ...) all the same: after a quarter of it the
    # pendulum hangs straight down.
    quarter = 0.5 * math.pi * math.sqrt(2.0 / G) * (1.0 + 0.3**2 / 16.0)
    assert abs(angle_after(quarter, quarter / 140, 5e5)) < 2e-4
    system, masses = pendulum(5e5)
    for _ in range(140):
        system.step(quarter / 140, weight(masses))
    swing = 2.0 * G * (1.0 - math.cos(0.3))  # v^2 / l, the centripetal part
    assert system.tension(0) == pytest.approx(1.5 * (G + swing), rel=0.06)


def test_a_hanging_chain_stretches_as_hookes_law_says_and_loses_energy_to_its_dampers_only():
    count, mass, stiffness, damping = 5, 0.4, 2000.0, 3.0
    masses = np.full(count, mass)
    x = np.array([[0.0, 0.0, -(i + 1.0)] for i in range(count)])
    springs = [Spring(i, i - 1 if i else GROUND, 1.0, stiffness, damping) for i in range(count)]
    system = ParticleSystem(x, np.zeros((count, 3)), masses, springs)
    step, lost, before = 0.0005, 0.0, system.energy() + G * float(masses @ x[:, 2])
    for _ in range(2000):
        half = system.damping_power()
        system.step(step, weight(masses))
        lost += 0.5 * step * (half + system.damping_power())
    after = system.energy() + G * float(masses @ system.x[:, 2])
    assert lost > 0.05
    assert after == pytest.approx(before - lost, abs=0.01 * lost)
    for _ in range(4000):
        system.step(0.01, weight(masses))
    stretch = [sum(masses[i:]) * G / stiffness for i in range(count)]
    expected = [-(i + 1.0) - math.fsum(stretch[: i + 1]) for i in range(count)]
    np.testing.assert_allclose(system.x[:, 2], expected, atol=1e-9)


def test_a_spring_keeps_its_share_of_stiffness_in_compression():
    masses = np.array([1.0])
    pressed = ParticleSystem(np.array([[0.0, 0.0, 0.9]]), np.zeros((1, 3)), masses,
                             [Spring(0, GROUND, 1.0, 1000.0, 0.0, 0.05)])
    assert pressed.tension(0) == pytest.approx(-0.05 * 1000.0 * 0.1)
    pressed.step(1e-6, lambda _x, _v, _out: None)
    assert pressed.v[0, 2] == pytest.approx(5.0 * 1e-6, rel=1e-3)
