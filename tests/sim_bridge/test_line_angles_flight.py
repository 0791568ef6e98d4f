"""A kite whose position is all that is measured, by two 12-bit encoders, tracks as well as with perfect ones.

A step q of 1.5 mrad is a uniform error of q / sqrt(12) on each angle, at both ends of the chord that the course is
taken from: sqrt(2) q / sqrt(12) = 0.63 mrad across it. In COURSE_WINDOW = 0.25 s the small kite flies a chord of
110 mrad, the V3 kite one of 16 mrad, so the course is off by 6 and 40 mrad RMS, and by as much again for the
correction of its lag. Both are small beside the turning angles of an eight.
"""

import math

import pytest

from firmware_py.drivers.as5600 import As5600
from firmware_py.drivers.line_angles import Axis, LineAngles
from sim_bridge.equipment.error_settings import MeasurementErrors
from sim_bridge.equipment.sensor_settings import SensorSettings
from sim_bridge.flight import flight as flights
from sim_bridge.plants.truth import Truth
from sim_bridge.runs.run import RunOptions, run_scenario
from sim_bridge.scenario.scenario import load_scenario
from tests.firmware_py.simulated_hardware import encoder_bus

STEP = 2.0 * math.pi / 4096
POSITION_ONLY = ("course", "heading", "airspeed", "distance", "steering")


def fly(name: str, resolution: float, missing: tuple[str, ...] = POSITION_ONLY, seed: int = 1):
    scenario = load_scenario(name)
    for quantity in missing:
        scenario.set(f"sensors.{quantity}", False, "")
    scenario.set("sensors.resolution_rad", resolution, "")
    scenario.set("run.seed", seed, "")
    return run_scenario(scenario, RunOptions()).numbers


@pytest.mark.parametrize("missing", [POSITION_ONLY, POSITION_ONLY[:2]], ids=["position only", "no course"])
@pytest.mark.parametrize("name", ["small-kite", "v3-flight"])
def test_it_tracks_with_steps_as_it_does_without(name, missing):
    stepped, smooth = fly(name, STEP, missing), fly(name, 0.0, missing)
    assert stepped["verdict"] == smooth["verdict"] == "tracking"
    assert stepped["cross_track_rms_rad"] < 1.35 * smooth["cross_track_rms_rad"]


def test_it_tracks_in_any_gusts():
    for seed in range(2, 6):
        flown = fly("v3-flight", STEP, seed=seed)
        assert flown["verdict"] == "tracking" and flown["cross_track_rms_rad"] < 0.04


class EncoderSensors:
    """The bridge's sensors, with the board's own driver reading two simulated encoders on the line."""

    def __init__(self, settings: SensorSettings, seed: int, errors: MeasurementErrors):
        (self._azimuth, azimuth), (self._elevation, elevation) = encoder_bus(), encoder_bus()
        self.angles = LineAngles(Axis(As5600(azimuth), 1234, -1), Axis(As5600(elevation), 4000, 1))
        _made.append(self)

    def follow(self, time_s: float, truth: Truth, steering: float) -> None:
        """Encoders read what is there."""

    def is_due(self, time_s: float) -> bool:
        return True

    def sample(self, time_us: int, truth: Truth, steering: float):
        x, y, z = truth.position
        self._azimuth.raw = (1234 - round(math.atan2(y, x) / STEP)) % 4096
        self._elevation.raw = (4000 + round(math.atan2(z, math.hypot(x, y)) / STEP)) % 4096
        sample = self.angles.sample(time_us)
        assert sample is not None
        return sample


_made: list[EncoderSensors] = []


@pytest.mark.parametrize("name", ["small-kite", "v3-flight"])
def test_the_board_s_own_driver_gives_the_same_flight_as_the_bridge_s_steps(name, monkeypatch):
    reference = fly(name, STEP)
    monkeypatch.setattr(flights, "Sensors", EncoderSensors)
    flown = fly(name, 0.0)
    driver = _made[-1].angles
    assert driver.refused == [0, 0, 0, 0]
    assert flown["verdict"] == "tracking"
    assert flown["cross_track_rms_rad"] == pytest.approx(reference["cross_track_rms_rad"], rel=0.2)
