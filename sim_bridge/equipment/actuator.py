"""The steering actuator: dead time, saturation, rate limit, first-order lag, solved exactly between commands."""

from math import exp
from typing import Final

from sim_bridge.equipment.actuator_settings import ActuatorSettings

_NEVER: Final = float("inf")


class _Command:
    """A steering that is felt from `felt_s` on."""

    def __init__(self, felt_s: float, steering: float) -> None:
        self.felt_s = felt_s
        self.steering = steering


class Actuator:
    """`position` is the actual steering at the time reached so far."""

    def __init__(self, settings: ActuatorSettings):
        self._dead_time = settings.dead_time_s
        self._rate = settings.rate_limit_per_s
        self._saturation = settings.saturation
        self._lag = settings.lag_s
        self.ideal = not self._rate and not self._lag
        self.position = 0.0
        self._target = 0.0
        self._pending: list[_Command] = []

    def command(self, time_s: float, steering: float) -> None:
        """Take a command at `time_s`, not before the command that came last."""
        self._pending.append(_Command(time_s + self._dead_time, steering))

    def next_change(self) -> float:
        """When the next command is felt [s]; infinity if none is pending."""
        return self._pending[0].felt_s if self._pending else _NEVER

    def apply_due(self, time_s: float) -> None:
        """Apply the commands that are due."""
        pending = self._pending
        while pending and pending[0].felt_s <= time_s:
            target = pending.pop(0).steering
            limit = self._saturation
            if limit and target > limit:
                target = limit
            elif limit and target < -limit:
                target = -limit
            self._target = target
        if self.ideal:
            self.position = self._target

    def advance(self, dt: float) -> float:
        """Move on by `dt` [s], while no further command is felt; return the mean position on the way."""
        target = self._target
        error = target - self.position
        if not error or self.ideal:
            self.position = target
            return target
        size = error if error > 0.0 else -error
        rate, lag = self._rate, self._lag
        missed, left = 0.0, dt  # integral of the error's size, and the time after a ramp
        slow = rate * lag  # error below which the lag is slower than the rate limit
        if rate and size > slow:
            to_slow = (size - slow) / rate
            ramp = to_slow if to_slow < dt else dt
            missed = ramp * (size - 0.5 * rate * ramp)
            size -= rate * ramp
            left -= ramp
        if lag:
            kept = exp(-left / lag)
            missed += size * lag * (1.0 - kept)
            size *= kept
        if error < 0.0:
            self.position = target + size
            return target + missed / dt
        self.position = target - size
        return target - missed / dt
