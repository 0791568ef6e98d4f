"""A quantity as a sensor with errors measures it."""

from math import remainder, tau
from random import Random

from sim_bridge.equipment.error_processes import Past, Wander
from sim_bridge.equipment.error_settings import NO_ERRORS, ErrorSettings


class MeasuredQuantity:
    """Truth, lag, scale, bias, wander, noise, in this order; dropouts are for others to tell.

    Each random part draws from a stream of its own, which comes from `seed`. A `circular` quantity is an angle that is
    kept within half a turn to either side.
    """

    def __init__(self, settings: ErrorSettings, seed: str, circular: bool = False) -> None:
        self._exact = settings == NO_ERRORS
        self._scale = settings.scale
        self._bias = settings.bias
        self._noise = settings.noise
        self._circular = circular
        self._random = Random(f"{seed}.noise")
        self._wander = (
            Wander(settings.wander, settings.wander_time_s, f"{seed}.wander") if settings.wander else None)
        self._past = Past(settings.lag_s, circular) if settings.lag_s else None
        self._time_s = 0.0
        self._truth = 0.0

    def follow(self, time_s: float, truth: float) -> None:
        """Take the true value at a tick."""
        self._time_s = time_s
        self._truth = truth
        if self._past is not None:
            self._past.add(time_s, truth)

    def read(self) -> float:
        """What the sensor reads at the tick that came last. To be asked once."""
        if self._exact:
            return self._truth
        value = self._truth if self._past is None else self._past.value()
        value = self._scale * value + self._bias
        if self._wander is not None:
            value += self._wander.at(self._time_s)
        if self._noise:
            value += self._random.gauss(0.0, self._noise)
        return remainder(value, tau) if self._circular else value
