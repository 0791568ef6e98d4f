"""The one-point kite: against the reference's numbers, against what can be worked out on paper, and in flight."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import UnivariateSpline
from scipy.optimize import root

from sim_bridge.errors import ScenarioError
from sim_bridge.flight.flight import Flight
from sim_bridge.flight.plant_choice import make_plant
from sim_bridge.plants.kite_settings import KiteSettings
from sim_bridge.plants.polars import Polars, coefficient, depower_angle
from sim_bridge.plants.tether import GRAVITY, add_tether_loads
from sim_bridge.runtimes.inproc import InprocRuntime
from sim_bridge.scenario.scenario import load_scenario
from sim_bridge.wind.air import Air

SMALL, REFERENCE = "small-kite-one-point", "reference-kite-one-point"
AIR = Air(7.0)


def scenario_with(name=SMALL, **changes):
    scenario = load_scenario(name)
    for key, value in changes.items():
        scenario.set(key.replace("__", "."), value, "test")
    return scenario


def kite_at(scenario, azimuth=0.0, elevation=0.6, course=0.5 * math.pi) -> Any:
    c, s = math.cos(elevation), math.sin(elevation)
    up = np.array([-s * math.cos(azimuth), -s * math.sin(azimuth), c])
    across = np.array([math.sin(azimuth), -math.cos(azimuth), 0.0])
    direction = math.cos(course) * up + math.sin(course) * across
    return make_plant(scenario, (c * math.cos(azimuth), c * math.sin(azimuth), s), tuple(direction))


def weave(kite, seconds, mirror=1.0):
    """Steer in a slow wave; positions of the kite (n, 3)."""
    places = []
    for i in range(round(seconds / 0.01)):
        kite.step(0.01, -mirror * math.sin(0.015 * i), AIR)
        places.append(kite.kite_position().copy())
    assert kite.trouble is None
    return np.array(places)


def test_polars_have_the_references_values_and_are_scipys_splines_everywhere():
    kite = KiteSettings()
    polars = Polars.of(kite)
    assert coefficient(polars.lift, math.radians(10.0)) == pytest.approx(0.5740976324, abs=1e-10)
    assert coefficient(polars.drag, math.radians(10.0)) == pytest.approx(0.1253368926, abs=1e-10)
    assert math.degrees(depower_angle(0.37)) == pytest.approx(20.499517, abs=1e-6)
    for kind in ("lift", "drag"):
        spline = UnivariateSpline(getattr(kite, f"{kind}_angles_deg"), getattr(kite, f"{kind}_coefficients"), k=3, s=0)
        for angle in np.linspace(-179.9, 179.9, 400):
            for turns in (-360.0, 0.0, 360.0):
                value = coefficient(getattr(polars, kind), math.radians(angle + turns))
                assert value == pytest.approx(np.asarray(spline(angle)).item(), abs=1e-9)


def test_in_steady_state_it_has_the_six_numbers_of_the_reference():
    scenario = scenario_with(REFERENCE, plant__line_length_m=392.0, kite__area_m2=10.0, wind__speed_m_s=9.1)
    kite = kite_at(scenario, elevation=math.radians(65.0))
    system, tether = kite.system, kite.tether
    system.v[:] = 0.0

    def net_force(plane):
        system.x[:, [0, 2]] = plane.reshape(-1, 2)
        kite.feel(Air(9.1))
        force = np.zeros_like(system.x)
        kite.forces(system.x, system.v, force)
        lines = np.diff(system.x, axis=0, prepend=0.0)
        pulls = [system.tension(i) * line / np.linalg.norm(line) for i, line in enumerate(lines)]
        return (force - np.array(pulls) + np.array([*pulls[1:], np.zeros(3)]))[:, [0, 2]].ravel()

    solution = root(net_force, system.x[:, [0, 2]].ravel(), tol=1e-12)
    assert np.max(np.abs(net_force(solution.x))) < 1e-6
    lift, drag = kite.lift_and_drag()
    lowest, ground_drag = system.x[:1], np.zeros((1, 3))  # the winch bears the lower half of the lowest segment's drag
    density = kite.density * math.exp((kite.kite_position()[2] - lowest[0, 2]) / 8550.0)
    add_tether_loads(lowest, system.v[:1], 1, tether.diameter_m, tether.drag_coefficient, density, kite.tether_wind,
                     ground_drag)
    winch = np.linalg.norm(system.tension(0) * lowest[0] / np.linalg.norm(lowest[0]) + ground_drag[0])
    stretched = np.add.reduce(np.linalg.norm(np.diff(system.x, axis=0, prepend=0.0), axis=1))
    numbers = winch, lift, drag, lift / drag, stretched, kite.wind[0]
    assert numbers == pytest.approx((276.2575, 443.6328, 94.2522, 4.706870, 392.1861, 9.1077), rel=1e-5)


def test_a_mirrored_kite_flies_the_mirrored_flight():
    here = weave(kite_at(scenario_with(), azimuth=0.1, course=1.2), 4.0)
    there = weave(kite_at(scenario_with(), azimuth=-0.1, course=-1.2), 4.0, mirror=-1.0)
    np.testing.assert_allclose(there, here * [1.0, -1.0, 1.0], atol=1e-9)
    assert np.ptp(here[:, 1]) > 10.0


def test_it_starts_in_steady_flight():
    kite = kite_at(scenario_with(), elevation=0.5)
    start = kite.truth()
    for _ in range(50):
        kite.step(0.01, 0.0, AIR)
        assert kite.truth().airspeed == pytest.approx(start.airspeed, rel=0.04)
        assert kite.truth().tether_force == pytest.approx(start.tether_force, rel=0.12)
    assert start.course == pytest.approx(0.5 * math.pi)


def test_wind_and_weight_do_all_work_and_the_tethers_dampers_take_the_rest():
    kite, dt = kite_at(scenario_with(plant__step_s=0.001, tether__damping_n_s=2000.0)), 0.001
    system = kite.system

    def energy():
        return system.energy() + GRAVITY * float(system.masses @ system.x[:, 2])

    def powers():
        force = np.zeros_like(system.x)
        kite.forces(system.x, system.v, force)
        force[:, 2] += GRAVITY * system.masses
        each = np.add.reduce(force * system.v, axis=1)
        return np.array([np.add.reduce(each), -system.damping_power(), np.max(np.abs(each))])

    before, done, moved = energy(), np.zeros(2), 0.0
    last = powers()
    for i in range(3000):
        kite.step(dt, -math.sin(1.5 * i * dt), AIR)
        now = powers()
        done += 0.5 * dt * (last + now)[:2]
        moved += dt * now[2]
        last = now
    assert kite.trouble is None and abs(done[0]) > 100.0
    assert energy() - before == pytest.approx(done[0] + done[1], abs=0.003 * moved)


def test_half_the_step_makes_next_to_no_difference():
    def flown(step):
        # An ideal actuator: with a rate limit its own steps would be seen as well.
        flight = Flight(scenario_with(plant__step_s=step, actuator__rate_limit_per_s=0.0), InprocRuntime())
        flight.fly(20.0)
        rows = np.array(flight.rows)
        return rows[:, 1:3], flight.plant.truth().tether_force

    (places, force), (finer, fine_force) = flown(0.01), flown(0.0025)  # the former flies steps of 5 ms
    assert np.max(np.abs(places - finer)) < 1e-3
    assert force == pytest.approx(fine_force, rel=0.01)


@pytest.mark.parametrize(("name", "turbulence"), [(SMALL, 0.0), (SMALL, 0.15), (REFERENCE, 0.15)])
def test_the_firmware_flies_it_for_ten_minutes(name, turbulence):
    flight = Flight(scenario_with(name, wind__turbulence_intensity=turbulence), InprocRuntime())
    kite: Any = flight.plant
    energies, stretches = [], []
    for second in range(600):
        flight.fly(second + 1.0)
        energies.append(kite.system.energy())
        stretches.append(kite.truth().distance / kite.tether.length_m - 1.0)
    metrics = flight.metrics()
    assert kite.trouble is None
    assert metrics.verdict == "tracking"
    assert metrics.cross_track_rms_rad is not None and metrics.cross_track_rms_rad < 0.08
    assert max(energies) < 8.0 * np.median(energies)  # elastic energy goes with the wind to the fourth
    assert min(stretches) > -0.005 and max(stretches) < 0.01


def test_the_turning_rate_law_comes_out_with_the_constant_that_its_side_force_says():
    scenario = scenario_with()
    flight = Flight(scenario, InprocRuntime())
    flight.fly(60.0)
    _, azimuth, elevation, _, heading, airspeed, steering = np.array(flight.rows)[250:, :7].T
    turning = np.gradient(np.unwrap(heading), 0.02) + np.gradient(azimuth, 0.02) * np.sin(elevation)
    drop = np.sin(heading) * np.cos(elevation)
    causes = np.stack([airspeed * steering, np.ones_like(drop), drop / airspeed], axis=1)
    (turn_k, offset, gravity), *_ = np.linalg.lstsq(causes, turning, rcond=None)
    rest = turning - causes @ [turn_k, offset, gravity]
    assert np.var(rest) < 0.005 * np.var(turning)
    mass = 6.0 + 40.0 * 0.011 / 3.0  # what a line that is held at its end adds
    expected = 0.5 * 1.22 * 5.0 * 0.306 * 2.59 / mass
    assert turn_k == pytest.approx(expected, rel=0.06)
    assert abs(offset) < 0.01
    assert scenario.parameter("TURN_K") == pytest.approx(turn_k, rel=0.02)
    assert scenario.parameter("GRAVITY_C") == pytest.approx(gravity, rel=0.15)


LULL = [Air(7.0 * min(1.0, max(0.0, abs(t - 500) / 200 - 1.0))) for t in range(1500)]
TURN = [Air(7.0, 0.0 if t < 300 else math.pi) for t in range(1500)]
CALM = [AIR] * 1500


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("length", "steering", "elevation", "course", "airs"), [
    (40.0, 0.3, 0.6, 1.57, LULL), (40.0, 1.0, 0.6, 1.57, LULL), (40.0, 0.3, 0.6, 1.57, TURN),
    (40.0, 0.0, 0.9, 0.0, TURN), (40.0, 1.0, 0.6, 1.57, CALM), (40.0, -1.0, 0.6, 1.57, CALM),
    (5.0, 1.0, 0.6, 1.57, CALM), (1500.0, 1.0, 0.6, 1.57, CALM), (40.0, 0.0, 1.1, 0.0, CALM),
    (40.0, 0.0, 0.2, 1.57, CALM)])
def test_whatever_happens_it_flies_or_says_why_not(length, steering, elevation, course, airs):
    kite = kite_at(scenario_with(plant__line_length_m=length), elevation=elevation, course=course)
    before = kite.system.energy()
    for air in airs * (3 if length == 40.0 else 1):
        kite.step(0.01, steering, air)
        truth = kite.truth()
        rest = truth.course, truth.heading, truth.distance, truth.airspeed, truth.tether_force
        assert all(map(math.isfinite, (*truth.position, *truth.velocity, *rest)))
        assert kite.system.energy() < 20.0 * before + 5000.0
        if kite.trouble:
            break
    if kite.trouble:
        assert kite.trouble.startswith("the kite crashed in ") and "\n" not in kite.trouble
        assert kite.kite_position()[2] < 0.5
        end = vars(kite.truth())
        kite.step(0.01, 0.0, AIR)
        assert vars(kite.truth()) == end


@pytest.mark.parametrize(("elevation", "course", "changes", "reason"), [
    (0.6, 1.57, {"wind__speed_m_s": 0.0}, "0.0 m/s of wind the kite cannot fly at the start: no force drives it"),
    (0.6, 1.57, {"wind__speed_m_s": 0.5}, "0.5 m/s of wind the kite cannot fly at the start"),
    (0.01, 1.57, {}, "would start 0.4 m above the ground"),
    (1.5, 0.0, {}, "no force drives it along its course"),
    (0.6, 1.57, {"kite__drag_angles_deg": (-180.0, 0.0, 180.0)}, "has 3 numbers, kite.drag_coefficients 11"),
    (0.6, 1.57, {"kite__lift_angles_deg": tuple(range(-180, -168))}, "from -180 to 180")])
def test_where_it_cannot_fly_it_says_so_in_a_line(elevation, course, changes, reason):
    with pytest.raises(ScenarioError, match=reason) as error:
        kite_at(scenario_with(**changes), elevation=elevation, course=course)
    assert "\n" not in str(error.value)


def test_without_the_compiler_it_flies_the_same():
    script = (
        "import json, sys; sys.path.insert(0, sys.argv[1])\n"
        "from test_one_point_kite import kite_at, scenario_with, weave\n"
        "print(json.dumps(weave(kite_at(scenario_with()), 1.0)[-1].tolist()))")
    plain = subprocess.run(
        [sys.executable, "-c", script, str(Path(__file__).parent)], capture_output=True, text=True, check=True,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"})
    compiled = weave(kite_at(scenario_with()), 1.0)[-1]
    np.testing.assert_allclose(json.loads(plain.stdout), compiled, rtol=1e-9)
