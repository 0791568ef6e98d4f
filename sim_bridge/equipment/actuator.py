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
        while self.next_change() <= time_s:
            target = self._pending.pop(0).steering
            limit = self._saturation
            self._target = max(-limit, min(limit, target)) if limit else target
        if self.ideal:
            self.position = self._target

    def position_after(self, dt: float) -> float:
        """Position `dt` [s] on, while no further command is felt."""
        error = self._target - self.position
        if not error or self.ideal:
            return self._target
        size, sign = abs(error), 1.0 if error > 0 else -1.0
        if self._rate:
            slow = self._rate * self._lag  # error below which the lag is slower than the rate limit
            if size > slow:
                ramp = min(dt, (size - slow) / self._rate)
                size -= self._rate * ramp
                dt -= ramp
        size = size * exp(-dt / self._lag) if self._lag else (size if self._rate else 0.0)
        return self._target - sign * size

    def mean_over(self, dt: float) -> float:
        """Mean position over the next `dt` [s], while no further command is felt."""
        error = self._target - self.position
        if not error or self.ideal:
            return self._target
        size, sign, left = abs(error), 1.0 if error > 0 else -1.0, dt
        missed = 0.0  # integral of the error's size
        slow = self._rate * self._lag
        if self._rate and size > slow:
            ramp = min(dt, (size - slow) / self._rate)
            missed = ramp * (size - 0.5 * self._rate * ramp)
            size -= self._rate * ramp
            left -= ramp
        if self._lag:
            missed += size * self._lag * (1.0 - exp(-left / self._lag))
        return self._target - sign * missed / dt

    def advance(self, dt: float) -> None:
        """Move on by `dt` [s]."""
        self.position = self.position_after(dt)
