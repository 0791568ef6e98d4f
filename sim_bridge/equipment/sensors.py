"""Sensor models: which quantities, how often, how accurately."""

from random import Random
from typing import Final

from protocol import dialect
from protocol.single_precision import float32
from sim_bridge.equipment.error_settings import EXACT, MeasurementErrors
from sim_bridge.equipment.sensor_errors import SensorErrors
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
    """Takes samples; what comes from chance does so from `seed`.

    The noise and the resolution of `settings` come on top of `errors`.
    """

    def __init__(self, settings: SensorSettings, seed: int, errors: MeasurementErrors = EXACT):
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
        self._errors = SensorErrors(errors, seed) if errors.any() else None

    def follow(self, time_s: float, truth: Truth, steering: float) -> None:
        """Take what there is to measure at a tick, whether a sample is due or not."""
        if self._errors is not None:
            self._errors.follow(time_s, truth, steering)

    def is_due(self, time_s: float) -> bool:
        """True when a sample is to be taken at `time_s`."""
        if not self._rate:
            return True
        if time_s < self._next - 1e-9:
            return False
        self._next = max(self._next, time_s - 1.0 / self._rate) + 1.0 / self._rate
        return True

    def sample(self, time_us: int, truth: Truth, steering: float) -> Sample:
        """One sample of `truth` and the actual `steering`, which were followed up to now, stamped `time_us`."""
        azimuth, elevation, distance = truth.azimuth, truth.elevation, truth.distance
        course, heading, airspeed = truth.course, truth.heading, truth.airspeed
        tether_force, valid, errors = truth.tether_force, self._valid, self._errors
        if errors is not None:
            azimuth, elevation, distance = errors.azimuth.read(), errors.elevation.read(), errors.distance.read()
            course, heading, airspeed = errors.course.read(), errors.heading.read(), max(0.0, errors.airspeed.read())
            tether_force, steering = errors.tether_force.read(), errors.steering.read()
            valid &= ~errors.missing()
        gauss = self._random.gauss
        if self._noise:
            azimuth += gauss(0.0, self._noise)
            elevation += gauss(0.0, self._noise)
        if self._resolution:
            azimuth = round(azimuth / self._resolution) * self._resolution
            elevation = round(elevation / self._resolution) * self._resolution
        if self._course_noise:
            course += gauss(0.0, self._course_noise)
            heading += gauss(0.0, self._course_noise)
        if self._airspeed_noise:
            airspeed = max(0.0, airspeed * (1.0 + gauss(0.0, self._airspeed_noise)))
        return make_sample(
            time_us, azimuth, elevation, distance, course, heading, airspeed, tether_force, steering, valid)
