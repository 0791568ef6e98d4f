"""The scenario's section `errors`: what is wrong with each measured quantity."""

from dataclasses import dataclass
from typing import NamedTuple

from sim_bridge.settings import Settings, number

QUANTITIES = {  # what each is, and its unit
    "position": ("azimuth and elevation", "rad"), "course": ("course", "rad"), "heading": ("heading", "rad"),
    "distance": ("distance", "m"), "airspeed": ("airspeed", "m/s"), "tether_force": ("tether force", "N"),
    "steering": ("actual steering", ""),
}
_MOST = 1e5  # in any of these units


@dataclass(frozen=True, kw_only=True)
class ErrorSettings(Settings):
    """Errors of one quantity; by default it is measured exactly.

    Noise, wander and bias are in the unit of the quantity, as data sheets have offsets; what grows with the reading is
    the scale. They come one after the other: truth, lag, scale, bias, wander, noise.
    """

    noise: float = number(0.0, "white noise, standard deviation", 0.0, _MOST)
    wander: float = number(0.0, "noise that wanders slowly (first-order Gauss-Markov), standard deviation", 0.0, _MOST)
    wander_time_s: float = number(60.0, "correlation time of the wander [s]", 0.01, 1e5)
    bias: float = number(0.0, "constant error", -_MOST, _MOST)
    scale: float = number(1.0, "factor on the true value", -10.0, 10.0)
    lag_s: float = number(0.0, "the value is that of so long ago [s], and is stamped as that of now", 0.0, 10.0)
    dropout: float = number(0.0, "fraction of the samples without a valid value", 0.0, 1.0)
    dropout_s: float = number(0.0, "mean length of a dropout [s]; 0: each sample for itself", 0.0, 1000.0)


NO_ERRORS = ErrorSettings()


class MeasurementErrors(NamedTuple):
    """The errors of all QUANTITIES. Azimuth and elevation have those of `position`, each by draws of its own."""

    position: ErrorSettings = NO_ERRORS
    course: ErrorSettings = NO_ERRORS
    heading: ErrorSettings = NO_ERRORS
    distance: ErrorSettings = NO_ERRORS
    airspeed: ErrorSettings = NO_ERRORS
    tether_force: ErrorSettings = NO_ERRORS
    steering: ErrorSettings = NO_ERRORS

    def any(self) -> bool:
        """True if there is an error at all."""
        return any(settings != NO_ERRORS for settings in self)


EXACT = MeasurementErrors()
