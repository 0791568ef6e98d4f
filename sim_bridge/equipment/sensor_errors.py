"""All quantities of a sample, with the errors that a scenario gives them."""

from protocol import dialect
from sim_bridge.equipment.error_processes import Dropouts
from sim_bridge.equipment.error_settings import ErrorSettings, MeasurementErrors
from sim_bridge.equipment.measured_quantity import MeasuredQuantity
from sim_bridge.plants.truth import Truth


class SensorErrors:
    """The quantities of a sample by name; what comes from chance does so from `seed`, each error for itself."""

    def __init__(self, errors: MeasurementErrors, seed: int) -> None:
        self.azimuth = MeasuredQuantity(errors.position, f"{seed}:errors.position.azimuth", circular=True)
        self.elevation = MeasuredQuantity(errors.position, f"{seed}:errors.position.elevation")
        self.course = MeasuredQuantity(errors.course, f"{seed}:errors.course", circular=True)
        self.heading = MeasuredQuantity(errors.heading, f"{seed}:errors.heading", circular=True)
        self.distance = MeasuredQuantity(errors.distance, f"{seed}:errors.distance")
        self.airspeed = MeasuredQuantity(errors.airspeed, f"{seed}:errors.airspeed")
        self.tether_force = MeasuredQuantity(errors.tether_force, f"{seed}:errors.tether_force")
        self.steering = MeasuredQuantity(errors.steering, f"{seed}:errors.steering")
        self._dropouts = [
            _Bits(errors.position, f"{seed}:errors.position",
                  dialect.KITE_VALID_AZIMUTH | dialect.KITE_VALID_ELEVATION),
            _Bits(errors.course, f"{seed}:errors.course", dialect.KITE_VALID_COURSE),
            _Bits(errors.heading, f"{seed}:errors.heading", dialect.KITE_VALID_HEADING),
            _Bits(errors.distance, f"{seed}:errors.distance", dialect.KITE_VALID_DISTANCE),
            _Bits(errors.airspeed, f"{seed}:errors.airspeed", dialect.KITE_VALID_AIRSPEED),
            _Bits(errors.tether_force, f"{seed}:errors.tether_force", dialect.KITE_VALID_TETHER_FORCE),
            _Bits(errors.steering, f"{seed}:errors.steering", dialect.KITE_VALID_STEERING),
        ]
        self._time_s = 0.0

    def follow(self, time_s: float, truth: Truth, steering: float) -> None:
        """Take the truth and the steering's at a tick."""
        self._time_s = time_s
        self.azimuth.follow(time_s, truth.azimuth)
        self.elevation.follow(time_s, truth.elevation)
        self.course.follow(time_s, truth.course)
        self.heading.follow(time_s, truth.heading)
        self.distance.follow(time_s, truth.distance)
        self.airspeed.follow(time_s, truth.airspeed)
        self.tether_force.follow(time_s, truth.tether_force)
        self.steering.follow(time_s, steering)

    def missing(self) -> int:
        """The validity bits of what drops out at the tick that came last. To be asked once."""
        missing = 0
        for bits in self._dropouts:
            if bits.dropouts.missing_at(self._time_s):
                missing |= bits.bits
        return missing


class _Bits:
    """The validity `bits` that a dropout clears."""

    def __init__(self, settings: ErrorSettings, seed: str, bits: int) -> None:
        self.dropouts = Dropouts(settings.dropout, settings.dropout_s, f"{seed}.dropout")
        self.bits = bits
