"""The four-point kite against the published numbers, against what holds for any kite, and in the loop."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sim_bridge.errors import ScenarioError
from sim_bridge.flight.flight import Flight
from sim_bridge.flight.plant_choice import make_plant
from sim_bridge.flight.truth_columns import COLUMNS
from sim_bridge.plants.four_point import FourPointKite
from sim_bridge.plants.four_point_forces import Sizes, add_wing_forces
from sim_bridge.plants.four_point_geometry import Shape
from sim_bridge.plants.four_point_settings import FourPointSettings
from sim_bridge.plants.kite_settings import KiteSettings
from sim_bridge.runtimes.inproc import InprocRuntime
from sim_bridge.scenario.scenario import Scenario, load_scenario
from sim_bridge.wind.air import Air

POD = np.array([75.0, 0.0, 129.90381057])
DOWN = -POD / np.linalg.norm(POD)
NOSE = np.array([DOWN[2], 0.0, -DOWN[0]])  # up along the meridian
WIND = Air(8.0)
REFERENCE = FourPointSettings(kite=KiteSettings(mass_kg=6.21))


def kite(azimuth=-0.5, elevation=0.6, course=-1.57, **changes) -> Any:
    scenario = Scenario("test")
    for key, value in {"plant__kind": "four-point", "plant__step_s": 0.005, **changes}.items():
        scenario.set(key.replace("__", "."), value, "test")
    c, s = math.cos(elevation), math.sin(elevation)
    up = np.array([-s * math.cos(azimuth), -s * math.sin(azimuth), c])
    across = np.array([math.sin(azimuth), -math.cos(azimuth), 0.0])
    direction = math.cos(course) * up + math.sin(course) * across
    x, y, z = (float(value) for value in direction)
    return make_plant(scenario, (c * math.cos(azimuth), c * math.sin(azimuth), s), (x, y, z))


def test_points_springs_and_masses_are_the_published_ones():
    shape = Shape.of(REFERENCE)
    np.testing.assert_allclose(shape.points(POD, NOSE, DOWN), [
        [76.5905217, 0.0, 134.6435550], [78.5650, 0.0, 136.0785717], [77.4500, 2.4811, 134.1473350],
        [77.4500, -2.4811, 134.1473350]], atol=1e-7)
    springs = shape.springs(5)
    assert [spring[:2] for spring in springs] == [
        (5, 6), (8, 6), (8, 9), (7, 8), (9, 5), (8, 5), (7, 9), (9, 6), (6, 7)]
    np.testing.assert_allclose(
        [spring.length for spring in springs],
        [4.998493791, 2.671692035, 4.96120756, 3.335312002, 5.49124686, 5.49124686, 3.335312002, 2.671692035,
         2.440379941], rtol=1e-8)
    assert springs[0].stiffness == pytest.approx(54012.39452, rel=1e-6)
    assert springs[0].damping == pytest.approx(94.62850606, rel=1e-6)
    assert springs[4].stiffness == pytest.approx(49165.63133, rel=1e-6)
    np.testing.assert_allclose(shape.masses(), [2.9187, 1.31652, 0.98739, 0.98739], rtol=1e-12)
    system = kite(plant__line_length_m=150.0, kite__mass_kg=6.21).system
    assert system.masses[5] == pytest.approx(8.4 + 0.5 * 25.0 * 0.011)


def test_the_air_forces_are_the_published_ones():
    sizes = Sizes.of(REFERENCE)._replace(segments=1, top_angle=math.radians(5.0) - 0.1)
    points = np.vstack((POD, Shape.of(REFERENCE).points(POD, NOSE, DOWN)))
    forces = np.zeros((5, 3))
    add_wing_forces(points, np.zeros((5, 3)), 1, 0.1, 1.25, np.array([8.0, 0.2, 0.0]), sizes, forces)
    np.testing.assert_allclose(-forces[2:], [  # published with the sign turned round
        [-81.3257, -2.0332, -454.1533], [-9.9385, -68.9151, -0.9905], [-11.4093, 53.2875, 0.7728]], rtol=1e-4)
    assert not forces[:2].any()


def test_a_mirrored_start_and_steering_give_the_mirrored_flight():
    left, right = kite(0.4, 0.6, 1.2), kite(-0.4, 0.6, -1.2)
    for tick in range(300):
        steering = 0.4 * math.sin(0.03 * tick)
        left.step(0.02, steering, WIND)
        right.step(0.02, -steering, WIND)
    here, there = left.truth(), right.truth()
    np.testing.assert_allclose(here.position, np.array(there.position) * [1.0, -1.0, 1.0], atol=1e-7)
    assert here.heading == pytest.approx(-there.heading, abs=1e-6)
    assert here.tether_force == pytest.approx(there.tether_force, rel=1e-6)


@pytest.mark.parametrize("course", [0.0, 1.5, 3.0, -1.5])
def test_it_starts_where_it_is_told_in_a_flight_that_goes_on_like_that(course):
    plant = kite(0.3, 0.55, course, plant__line_length_m=150.0)
    start = plant.truth()
    assert math.atan2(start.position[1], start.position[0]) == pytest.approx(0.3, abs=1e-6)
    assert math.asin(start.position[2]) == pytest.approx(0.55, abs=1e-6)
    assert start.course == pytest.approx(course, abs=1e-6)
    assert 1.0 < plant.system.tension(0) / plant.tether.stiffness_n * 1e3 < 10.0
    for _ in range(25):
        plant.step(0.02, 0.0, WIND)
        truth = plant.truth()
        assert truth.airspeed == pytest.approx(start.airspeed, rel=0.08)
        assert truth.tether_force == pytest.approx(start.tether_force, rel=0.16)


def test_the_power_of_air_and_weight_less_that_of_the_dampers_is_the_gain_of_energy():
    plant = kite(elevation=0.8, course=3.1, plant__line_length_m=150.0)
    system, force = plant.system, np.zeros_like(plant.system.x)

    def power():
        force.fill(0.0)
        plant.forces(system.x, system.v, force)
        return float(np.vdot(force, system.v)) - system.damping_power()

    before, work = system.energy(), 0.0
    for tick in range(2000):
        plant.steering = 0.3 * math.sin(0.002 * tick)
        work += 0.0005 * power()
        plant.step(0.001, plant.steering, WIND)
        work += 0.0005 * power()
    gain = system.energy() - before
    assert gain > 1500.0
    assert work == pytest.approx(gain, rel=0.001)


def fly(name, seconds, **changes):
    scenario = load_scenario(name)
    for key, value in changes.items():
        scenario.set(key.replace("__", "."), value, "test")
    flight = Flight(scenario, InprocRuntime())
    plant, strain, energies = flight.plant, 0.0, []
    assert isinstance(plant, FourPointKite)
    lengths = plant.system.springs[plant.tether.segments :, 0]
    pairs = plant.system.ends[plant.tether.segments :]
    while flight.time_s < seconds - 1e-9 and not plant.trouble:
        flight.step()
        if flight.tick % 5 == 0:
            x = plant.system.x
            now = np.linalg.norm(x[pairs[:, 0]] - x[pairs[:, 1]], axis=1)
            strain = max(strain, float(np.max(np.abs(now / lengths - 1.0))))
            energies.append(plant.system.energy())
    assert plant.trouble is None
    return flight, strain, energies


@pytest.mark.parametrize("name", ["small-kite-four-point", "reference-kite-four-point"])
@pytest.mark.parametrize("turbulence", [0.0, 0.15])
def test_ten_minutes_of_eights_are_tracked_in_steady_and_in_turbulent_wind(name, turbulence):
    flight, strain, energies = fly(name, 600.0, wind__turbulence_intensity=turbulence)
    metrics = flight.metrics()
    assert metrics.verdict == "tracking"
    assert metrics.cross_track_rms_rad is not None and metrics.cross_track_rms_rad < 0.05
    assert metrics.saturated_fraction is not None and metrics.saturated_fraction < 0.01
    assert strain < 0.03
    quarter = len(energies) // 4
    assert max(energies[3 * quarter :]) < 2.0 * max(energies[:quarter])


@pytest.mark.parametrize(("name", "k", "c2", "r2"), [
    ("reference-kite-four-point", 0.154, 3.7, 0.995), ("small-kite-four-point", 0.176, None, 0.97)])
def test_the_turning_rate_law_comes_out(name, k, c2, r2):
    """The heading's rate on top of meridian convergence, against airspeed times steering and weight."""
    flight, _, _ = fly(name, 60.0)
    rows = {column: np.array(values) for column, values in zip(COLUMNS, zip(*flight.rows, strict=True), strict=True)}
    time_s, azimuth, elevation = rows["time_s"], np.unwrap(rows["azimuth_rad"]), rows["elevation_rad"]
    heading, airspeed = np.unwrap(rows["heading_rad"]), rows["airspeed_m_s"]
    turning = np.gradient(heading, time_s) + np.gradient(azimuth, time_s) * np.sin(elevation)
    lag = 2
    weight = np.sin(heading) * np.cos(elevation) / airspeed
    sources = np.column_stack((airspeed[lag:] * rows["steering"][:-lag], np.ones(len(turning) - lag), weight[lag:]))
    turning = turning[lag:]
    found, *_ = np.linalg.lstsq(sources, turning, rcond=None)
    explained = 1.0 - np.var(turning - sources @ found) / np.var(turning)
    assert explained > r2
    assert found[0] == pytest.approx(k, rel=0.05)
    assert abs(found[1]) < 0.01
    if c2:
        assert found[2] == pytest.approx(c2, rel=0.1)


def test_full_steering_to_either_side_turns_that_way():
    for steering in (1.0, -1.0):
        plant = kite(0.0, 0.6, 0.0, plant__line_length_m=150.0)
        before = plant.truth()
        for _ in range(50):
            plant.step(0.02, steering, WIND)
        after = plant.truth()
        assert (after.heading - before.heading) * steering > 0.5
        assert (after.course - before.course) * steering > 0.5


def test_halving_the_step_changes_the_flight_little():
    coarse, fine = (fly("small-kite-four-point", 40.0, plant__step_s=step)[0] for step in (0.005, 0.0025))
    here, there = coarse.metrics(), fine.metrics()
    assert here.cross_track_rms_rad == pytest.approx(there.cross_track_rms_rad, rel=0.01)
    assert here.steering_rms == pytest.approx(there.steering_rms, rel=0.01)


ONE_SECOND = """
import json
from tests.sim_bridge.test_four_point_kite import WIND, kite
plant = kite(plant__line_length_m=40.0)
for tick in range(50):
    plant.step(0.02, 0.4, WIND)
print(json.dumps([plant.system.x.tolist(), plant.system.v.tolist()]))
"""


def test_plain_python_flies_as_the_compiled_plant_does():
    folder = Path(__file__).parents[2]
    states = []
    for plain in ("0", "1"):
        done = subprocess.run(
            [sys.executable, "-c", ONE_SECOND], capture_output=True, text=True, check=True, cwd=folder,
            env={**os.environ, "NUMBA_DISABLE_JIT": plain})
        states.append(np.array(json.loads(done.stdout)))
    size = np.abs(states[0]).max(axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(states[0] / size, states[1] / size, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(("changes", "reason"), [
    ({"wind__speed_m_s": 2.0}, "2.0 m/s of wind: lift and drag are"),
    ({"wind__speed_m_s": 0.0}, "0.0 m/s of wind: lift and drag are"),
    ({"kite__mass_kg": 200.0}, "the weight"),
    ({"elevation": -0.1}, "above the ground"),
    ({"azimuth": 2.5, "elevation": 0.2}, "azimuth 143 deg"),
    ({"kite__side_area": 1.5}, "kite.side_area = 1.5 is below 1"),
])
def test_a_kite_that_cannot_fly_there_is_refused_with_the_reason(changes, reason):
    with pytest.raises(ScenarioError) as refusal:
        kite(**changes)
    assert reason in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("length", [5.0, 40.0, 400.0, 1500.0])
@pytest.mark.parametrize(("steering", "wind"), [
    (1.0, lambda _: 8.0), (-1.0, lambda _: 8.0), (0.0, lambda time_s: 8.0 if abs(time_s - 8.0) > 4.0 else 0.0),
    (0.1, lambda time_s: 8.0 + 8.0 * math.sin(time_s)), (0.2, lambda time_s: 8.0 if time_s < 3.0 else 40.0)])
def test_whatever_happens_it_flies_or_says_why_not(length, steering, wind):
    plant = kite(0.2, 0.9, 0.3, plant__line_length_m=length)
    for tick in range(3000):
        plant.step(0.02, steering, Air(wind(0.02 * tick)))
        truth = plant.truth()
        numbers = (*truth.position, *truth.velocity, truth.course, truth.heading, truth.distance, truth.airspeed,
                   truth.tether_force)
        assert all(math.isfinite(number) for number in numbers)
        assert truth.airspeed < 200.0
        assert truth.distance < 1.2 * (length + 8.0)
        if plant.trouble:
            break
    assert plant.trouble is None or plant.trouble.startswith(("the kite crashed", "the kite collapsed"))


def test_a_kite_that_folds_up_says_so():
    plant = kite()
    left, right = plant.system.x[-2], plant.system.x[-1]
    right[:] = left + 0.2 * (right - left)
    plant.step(1e-4, 0.0, WIND)
    assert plant.trouble is not None
    assert plant.trouble.startswith("the kite collapsed: its tips are 1.")
