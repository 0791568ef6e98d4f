"""The kite of the vortex lattice in flight: what comes out of the flow, and whether it is what physics asks for."""

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
from sim_bridge.runtimes.inproc import InprocRuntime
from sim_bridge.scenario.scenario import Scenario
from sim_bridge.wind.air import Air

SETTINGS = {
    "plant.kind": "vortex-lattice", "plant.line_length_m": 40.0, "wind.speed_m_s": 7.0, "tether.diameter_m": 0.003,
    "tether.mass_kg_m": 0.0062, "tether.stiffness_n": 345700.0, "tether.damping_n_s": 266.0}
AIR = Air(7.0)
UP_AT_THE_SIDE = (0.4, 0.6, 0.0)  # azimuth, elevation, course
TICK_S = 0.02


def scenario(**changes):
    result = Scenario("test")
    for key, value in {**SETTINGS, **{key.replace("__", "."): value for key, value in changes.items()}}.items():
        result.set(key, value, "test")
    return result


def kite(start=UP_AT_THE_SIDE, **changes) -> Any:
    azimuth, elevation, course = start
    c, s = math.cos(elevation), math.sin(elevation)
    up = np.array([-s * math.cos(azimuth), -s * math.sin(azimuth), c])
    across = np.array([math.sin(azimuth), -math.cos(azimuth), 0.0])
    direction = math.cos(course) * up + math.sin(course) * across
    position = (c * math.cos(azimuth), c * math.sin(azimuth), s)
    return make_plant(scenario(**changes), position, tuple(direction))


def fly(plant, seconds, steering, step=None, air=AIR):
    """Fly with `steering(time)`, held for a tick; the truth at each tick."""
    step = step or plant.step_s
    truths = []
    for tick in range(round(seconds / TICK_S)):
        truths.append(plant.truth())
        for _ in range(round(TICK_S / step)):
            plant.step(step, steering(tick * TICK_S), air)
    assert plant.trouble is None
    return truths


def firmware_flight(turbulence):
    """A minute of eights in gusts of that intensity, 0.2 s of dead time in the loop."""
    setting = scenario(link__control__delay_s=0.15, actuator__dead_time_s=0.05, actuator__rate_limit_per_s=4.0,
                       wind__turbulence_intensity=turbulence, wind__gusts="dryden", run__settle_s=10.0)
    parameters = {
        "TURN_K": 0.21875, "INNER_P": 1.0, "OUTER_L": 3.0, "FF_GAIN": 1.0, "LINE_LENGTH": 44.0,
        "EIGHT_ELEVATION": 35.0, "EIGHT_HALF_W": 35.0, "EIGHT_HALF_H": 9.0}
    for name, value in parameters.items():
        setting.set_parameter(name, value, "test")
    flight = Flight(setting, InprocRuntime())
    flight.fly(60.0)
    return flight


@pytest.fixture(scope="module")
def steady_flight():
    return firmware_flight(0.0)


def looping(time_s):
    return 0.4 + 0.2 * math.sin(2.0 * time_s)


def test_it_sets_off_as_it_flies_on():
    for start in (UP_AT_THE_SIDE, (0.3, 0.55, 1.5), (-0.5, 0.4, -1.0), (0.0, 0.9, 2.5)):
        truths = fly(kite(start), 0.6, lambda _: 0.0)
        speed = [t.airspeed for t in truths]
        assert max(speed) / min(speed) < 1.3  # what gravity and the place in the wind window do
        forces = [t.tether_force / t.airspeed**2 for t in truths]
        assert min(forces[10:]) > 0.93 * max(forces[10:])  # tether and bridle have stopped ringing
        assert max(t.distance for t in truths) - min(t.distance for t in truths) < 0.15
        assert abs(truths[0].course - start[2]) < 0.01


def test_mirrored_steering_flies_a_mirrored_path():
    one = fly(kite((0.3, 0.6, 0.2)), 3.0, looping)[-1]
    other = fly(kite((-0.3, 0.6, -0.2)), 3.0, lambda time_s: -looping(time_s))[-1]
    assert other.position == pytest.approx([one.position[0], -one.position[1], one.position[2]], abs=1e-6)
    assert other.heading == pytest.approx(-one.heading, abs=1e-6)


def test_the_turning_rate_law_comes_out_of_the_flow(steady_flight):
    """Heading rate, less meridian convergence, on Va u of 0.12 s ago, 1, and sin(psi) cos(elevation) / Va."""
    rows = np.array(steady_flight.rows)[500:]
    column = {name: rows[:, index] for index, name in enumerate(COLUMNS)}
    psi, elevation, airspeed = column["heading_rad"], column["elevation_rad"], column["airspeed_m_s"]
    rate = (np.gradient(np.unwrap(psi), TICK_S)
            + np.gradient(np.unwrap(column["azimuth_rad"]), TICK_S) * np.sin(elevation))
    terms = np.stack([airspeed * np.roll(column["steering"], 6), np.ones_like(psi),
                      np.sin(psi) * np.cos(elevation) / airspeed], axis=1)[10:]
    constants, *_ = np.linalg.lstsq(terms, rate[10:], rcond=None)
    left = rate[10:] - terms @ constants
    assert 1.0 - np.var(left) / np.var(rate[10:]) > 0.99
    assert 0.20 < constants[0] < 0.24
    assert abs(constants[1]) < 0.01
    assert 4.0 < constants[2] < 10.0  # gravity turns the nose down


def test_a_finer_lattice_turns_alike():
    """16 strips of 3 panels turn within 2 % of 24 strips of 5."""
    def turned(**changes):
        truths = fly(kite(**changes), 0.8, lambda _: 0.4)
        return truths[-1].heading - truths[0].heading

    assert turned() == pytest.approx(turned(wing__strips=24, wing__rows=5), rel=0.02)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_knock_dies_out(axis):
    """Roll, pitch or yaw by 2 rad/s at once, against a twin that is left alone."""
    plant, twin = kite((0.3, 0.55, 1.5)), kite((0.3, 0.55, 1.5))
    for each in (plant, twin):
        fly(each, 0.4, lambda _: 0.0)
    first = plant.tether.segments
    arm = plant.system.x[first:] - plant.kite_position()
    plant.system.v[first:] += np.cross(2.0 * plant.frame[axis], arm)

    def apart():
        return np.linalg.norm(plant.motion[3:] - twin.motion[3:])

    fly(plant, 0.02, lambda _: 0.0)
    fly(twin, 0.02, lambda _: 0.0)
    knocked = apart()
    fly(plant, 1.0, lambda _: 0.0)
    fly(twin, 1.0, lambda _: 0.0)
    assert apart() < 0.05 * max(knocked, 1.0)


def test_energy_comes_from_air_and_weight_and_goes_into_dampers_only():
    plant = kite()
    system, dt = plant.system, 0.004
    out = np.zeros_like(system.x)

    def powers():
        out.fill(0.0)
        plant.forces(system.x, system.v, out)
        return np.array([np.sum(out * system.v), -system.damping_power(), abs(np.sum(out * system.v))])

    before, work, power = system.energy(), np.zeros(3), powers()
    for step in range(1000):
        plant.step(dt, looping(step * dt), AIR)
        last, power = power, powers()
        work += 0.5 * dt * (last + power)
    assert work[2] > 1000.0
    assert system.energy() - before == pytest.approx(work[0] + work[1], abs=0.005 * work[2])


def test_half_the_step_flies_the_same():
    """0.1 m after 3 s and 60 m, in a turn."""
    whole, half = kite(), kite()
    fly(whole, 3.0, looping)
    fly(half, 3.0, looping, step=0.5 * half.step_s)
    assert np.linalg.norm(whole.kite_position() - half.kite_position()) < 0.1


def flown_for_a_bit():
    plant = kite(wing__strips=8, wing__rows=2)
    for _ in range(15):
        plant.step(0.004, 0.5, Air(7.0, 0.1, 0.1, -0.05, 0.05))
    return [*plant.system.x.ravel(), *plant.system.v.ravel(), *plant.flow.loads]


def test_plain_python_flies_as_the_compiled_code_does():
    code = "import json, test_vortex_lattice_plant as t; print(json.dumps(t.flown_for_a_bit()))"
    paths = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": paths}
    plain = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    compiled = np.array(flown_for_a_bit())
    assert compiled == pytest.approx(np.array(json.loads(plain.stdout)), rel=1e-9, abs=1e-8)


def test_without_wind_it_is_not_set_off_and_when_the_wind_dies_it_comes_down():
    with pytest.raises(ScenarioError, match="cannot fly steadily at the start"):
        kite(wind__speed_m_s=0.0)
    with pytest.raises(ScenarioError, match="cannot fly steadily at the start"):
        kite((2.0, 0.5, 0.0))
    plant = kite()
    for _ in range(5000):
        plant.step(0.004, 0.0, Air(0.0))
        if plant.trouble:
            break
    assert plant.trouble is not None and "crashed" in plant.trouble
    assert all(math.isfinite(value) for value in (*plant.truth().position, plant.truth().airspeed))


def test_the_firmware_flies_eights_with_it(steady_flight):
    for flight in (steady_flight, firmware_flight(0.2)):
        assert flight.plant.trouble is None
        metrics = flight.metrics()
        assert metrics.verdict == "tracking"
        assert metrics.cross_track_rms_rad is not None and metrics.cross_track_rms_rad < 0.1
        assert np.sum(np.abs(np.diff(np.sign(flight.track().azimuth[500:]))) == 2) >= 12  # it goes to and fro
