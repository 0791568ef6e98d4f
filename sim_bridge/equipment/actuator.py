"""The steering actuator: dead time, saturation, dead band, rate limit, first-order lag, and play behind the motor.

All of it is solved exactly between commands. The motor then goes one way, so that the play is taken up at most once.
"""

from typing import Final

from sim_bridge.equipment.actuator_settings import ActuatorSettings
from sim_bridge.equipment.approach import Approach

_NEVER: Final = float("inf")
# Of the dead band: so near to the command the motor has reached it. With a lag it would be on its way for ever.
_ARRIVED: Final = 1e-6
_ARRIVED_WITH_LAG: Final = 0.05


class _Command:
    """A steering that is felt from `felt_s` on."""

    def __init__(self, felt_s: float, steering: float) -> None:
        self.felt_s = felt_s
        self.steering = steering


class Actuator:
    """`position` is the actual steering at the time reached so far, `motor` that of the motor, before the play.

    A sensor on the motor's side measures `motor`. Without backlash the two are the same.
    """

    def __init__(self, settings: ActuatorSettings):
        self._dead_time = settings.dead_time_s
        self._saturation = settings.saturation
        self._dead_band = settings.dead_band
        self._half_play = 0.5 * settings.backlash
        self.ideal = not settings.rate_limit_per_s and not settings.lag_s
        self._stop = settings.dead_band * (_ARRIVED_WITH_LAG if settings.lag_s else _ARRIVED)
        self._approach = Approach(settings.rate_limit_per_s, settings.lag_s, self._stop)
        self.position = 0.0
        self.motor = 0.0
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
            moves = self._target != self.motor
            if moves or abs(target - self.motor) >= self._dead_band:
                self._target = target
            if self.ideal:
                self.motor = self._target
                self.position = self._behind_play(self.motor)

    def advance(self, dt: float) -> float:
        """Move on by `dt` [s], while no further command is felt; return the mean position on the way."""
        target = self._target
        error = target - self.motor
        if not error or self.ideal:
            return self.position
        approach = self._approach
        size = error if error > 0.0 else -error
        sign = 1.0 if error > 0.0 else -1.0
        if self._half_play:
            mean = self._mean_behind_play(size, sign, dt)
            approach.go(size, dt)
        else:
            approach.go(size, dt)
            mean = target - sign * approach.area / dt
        left = approach.left
        self.motor = target - sign * left
        self.position = self._behind_play(self.motor)
        if left <= self._stop:
            self._target = self.motor
        return mean

    def _behind_play(self, motor: float) -> float:
        """The steering when the motor has come to `motor`, on one way from where it is."""
        play = self._half_play
        return max(motor - play, min(motor + play, self.position)) if play else motor

    def _mean_behind_play(self, size: float, sign: float, dt: float) -> float:
        """The steering rests until the play is taken up, and follows half of it behind the motor then."""
        taken_up = min(size, sign * (self._target - self.position) - self._half_play)  # the size at which it is
        rest = self._approach.time_until(size, taken_up)
        if rest >= dt:
            return self.position
        follow = dt - rest
        ahead = self._target - sign * self._half_play
        self._approach.go(taken_up, follow)
        return (rest * self.position + follow * ahead - sign * self._approach.area) / dt
