"""Sensor models: which quantities, how often, how accurately."""

from random import Random
from typing import Final

from protocol import dialect
from protocol.single_precision import float32
from sim_bridge.equipment.sensor_settings import SensorSettings
from sim_bridge.plants.truth import Truth

SAMPLE_BYTES: Final = 50  # a KITE_SENSORS frame on the wire
_GIVEN: Final = {
    "course": dialect.KITE_VALID_COURSE, "heading": dialect.KITE_VALID_HEADING,
    "distance": dialect.KITE_VALID_DISTANCE, "airspeed": dialect.KITE_VALID_AIRSPEED,
    "steering": dialect.KITE_VALID_STEERING,
}

Sample = tuple[int, float, float, float, float, float, float, float, float, int]


def make_sample(time_us: int, azimuth: float, elevation: float, distance: float, course: float, heading: float,
                airspeed: float, tether_force: float, steering: float, valid: int) -> Sample:
    """Values of KITE_SENSORS in wire order, in the precision that the wire has."""
    return (time_us, float32(azimuth), float32(elevation), float32(distance), float32(course),
            float32(heading), float32(airspeed), float32(tether_force), float32(steering), valid)


class Sensors:
    """Takes samples; their noise comes from `seed`."""

    def __init__(self, settings: SensorSettings, seed: int):
        self._noise = settings.noise_rad
        self._resolution = settings.resolution_rad
        self._course_noise = settings.course_noise_rad
        self._airspeed_noise = settings.airspeed_noise
        self._rate = settings.rate_hz
        self._valid: int = dialect.KITE_VALID_AZIMUTH | dialect.KITE_VALID_ELEVATION | dialect.KITE_VALID_TETHER_FORCE
        for name, bit in _GIVEN.items():
            self._valid |= bit if getattr(settings, name) else 0
        self._random = Random(f"{seed}:sensors")
        self._next = float("-inf")

    def is_due(self, time_s: float) -> bool:
        """True when a sample is to be taken at `time_s`."""
        if not self._rate:
            return True
        if time_s < self._next - 1e-9:
            return False
        self._next = max(self._next, time_s - 1.0 / self._rate) + 1.0 / self._rate
        return True

    def sample(self, time_us: int, truth: Truth, steering: float) -> Sample:
        """One sample of `truth` and the actual `steering`, stamped `time_us`."""
        azimuth, elevation = truth.azimuth, truth.elevation
        gauss = self._random.gauss
        if self._noise:
            azimuth += gauss(0.0, self._noise)
            elevation += gauss(0.0, self._noise)
        if self._resolution:
            azimuth = round(azimuth / self._resolution) * self._resolution
            elevation = round(elevation / self._resolution) * self._resolution
        course, heading, airspeed = truth.course, truth.heading, truth.airspeed
        if self._course_noise:
            course += gauss(0.0, self._course_noise)
            heading += gauss(0.0, self._course_noise)
        if self._airspeed_noise:
            airspeed = max(0.0, airspeed * (1.0 + gauss(0.0, self._airspeed_noise)))
        return make_sample(time_us, azimuth, elevation, truth.distance, course, heading, airspeed, truth.tether_force,
                           steering, self._valid)
