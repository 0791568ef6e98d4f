"""Inner loop: from the turning-angle error to steering, within limits.

J. H. Baayen, "Trajectory tracking control of kites with system delay" (2012), section 2.1 and proposition 4.1.
"""

from math import pi, sin

from ..generated_enums import KITE_STATUS_AIRSPEED_FLOOR, KITE_STATUS_SATURATED, KITE_STATUS_SLEWED
from ..parameters.generated_parameters import (
    AIRSPEED_MIN,
    FF_GAIN,
    GRAVITY_C,
    STEER_MAX,
    STEER_RATE,
    TURN_OFFSET,
)
from ..sphere import TWO_PI

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .gains import Gains
    from .interface import Kite


class SteeringConfig:
    """Settings of the inner loop; see parameters.toml for units."""

    def __init__(self) -> None:
        self.feed_forward: float = 0.0
        self.turn_offset: float = 0.0
        self.gravity_c: float = 0.0
        self.airspeed_min: float = 1.0
        self.limit: float = 1.0
        self.rate_limit: float = 0.0

    def load(self, values: list[float]) -> None:
        """Load the settings from the parameters' `values`."""
        self.feed_forward = values[FF_GAIN]
        self.turn_offset = values[TURN_OFFSET]
        self.gravity_c = values[GRAVITY_C]
        self.airspeed_min = values[AIRSPEED_MIN]
        self.limit = values[STEER_MAX]
        self.rate_limit = values[STEER_RATE]


class Steering:
    """State of the inner loop: `asked`, the steering in [-1, 1], and what limited it in `status`."""

    def __init__(self) -> None:
        self.config = SteeringConfig()
        self.asked: float = 0.0
        self.error: float = 0.0  # turning-angle error [rad]
        self.status: int = 0

    def follow(self, target_course: float, target_rate: float, kite: "Kite", gains: "Gains", dt: float) -> None:
        """Steer the `kite` (an estimate) towards `target_course` [rad], which turns at `target_rate` [rad/s].

        u = (n (FF_GAIN d(theta_t)/dt + P wrap(theta_t - theta)) - gravity - offset) / (K Va), with n the kite's
        `turning_ratio` of nose to course, 1 for an estimate.
        """
        config = self.config
        self.status = 0
        airspeed = kite.airspeed
        if airspeed < config.airspeed_min:
            airspeed = config.airspeed_min
            self.status = KITE_STATUS_AIRSPEED_FLOOR
        error = (target_course - kite.course) % TWO_PI
        if error > pi:
            error -= TWO_PI
        self.error = error
        rate = config.feed_forward * target_rate
        gravity_rate = 0.0  # turning by gravity
        if config.gravity_c:
            gravity_rate = config.gravity_c / airspeed * sin(kite.heading) * kite.frame.e1z
        full = gains.turn_k * airspeed
        if kite.turning_slew:
            needed = kite.turning_ratio * rate - config.turn_offset - gravity_rate
            most = full * config.limit
            if needed > most:
                needed = most
            elif needed < -most:
                needed = -most
            error -= _still_turning(kite, needed)
        rate += gains.gain_p * error
        rate = kite.turning_ratio * rate - config.turn_offset - gravity_rate
        self._limit(rate / full, dt)

    def hold(self, steering: float, dt: float) -> None:
        """Ask for `steering` as given, within the limits."""
        self.status = 0
        self.error = 0.0
        self._limit(steering, dt)

    def release(self) -> None:
        """Ask for neutral steering, at once: nobody steers."""
        self.status = 0
        self.error = 0.0
        self.asked = 0.0

    def _limit(self, wanted: float, dt: float) -> None:
        config = self.config
        if wanted != wanted:  # not a number steers nowhere  # noqa: PLR0124
            wanted = 0.0
        limit = config.limit
        asked = wanted
        if wanted > limit:
            asked = limit
        elif wanted < -limit:
            asked = -limit
        if asked != wanted:
            self.status |= KITE_STATUS_SATURATED
        if config.rate_limit:
            before = _within(self.asked, config.limit)  # a limit that was lowered holds at once
            most = config.rate_limit * dt
            if abs(asked - before) > most:
                asked = before + (most if asked > before else -most)
                self.status |= KITE_STATUS_SLEWED
        self.asked = asked


def _within(value: float, limit: float) -> float:
    """`value`, or the limit that it is beyond."""
    return limit if value > limit else -limit if value < -limit else value


def _still_turning(kite: "Kite", needed: float) -> float:
    """How far the course turns [rad] beyond the target while an actuator with a rate limit comes to what is needed.

    It goes from the `steered_turning` that it makes to `needed` [rad/s of the nose] at its `turning_slew`.
    """
    surplus = kite.steered_turning - needed
    turned = 0.5 * surplus * (surplus if surplus > 0.0 else -surplus) / (kite.turning_slew * kite.turning_ratio)
    if turned < -pi:
        return -pi
    return turned if turned < pi else pi
