"""The kite's predicted velocity: through the air along its nose, plus the wind.

If course, heading and airspeed are measured, the velocity minus the airspeed along the nose is the wind across the
tether: the part (wx e1x + wy e1y, wx e2x + wy e2y), along e1 and e2, of a horizontal wind. That wind stays as it is
while the kite turns and flies around: M. Erhard and H. Strauch, "Control of towing kites for seagoing vessels" (2013).
The horizontal parts of e1 and e2 are at right angles, of length sin(elevation) and 1. If they are not measured, the
angle from heading to course is constant.
"""

from math import atan2, cos, sin, sqrt

from ..generated_enums import KITE_VALID_AIRSPEED, KITE_VALID_HEADING

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

    from ..estimation.estimator import Estimator

_NEEDED = KITE_VALID_AIRSPEED | KITE_VALID_HEADING  # type: Final
_SMOOTHING = 4.0  # type: Final  # of the wind, so that it is no gust's [s]
_LEAST_SQUARE = 0.1  # type: Final  # of sin(elevation): a low kite sees too little of the wind along its azimuth
_LEAST_RATIO = 0.5  # type: Final
_MOST_RATIO = 2.0  # type: Final


class Drift:
    """`forward` and `sideways` are the velocity along the nose h and b = gamma x h, over line length [1/s]."""

    def __init__(self) -> None:
        self.forward: float = 0.0
        self.sideways: float = 0.0
        self.speed: float = 0.0
        self.turning_ratio: float = 1.0  # how much the nose must turn for the course to turn by one
        self.blown: bool = False  # True where the wind is known and turns past
        self._wind_x: float = 0.0  # over line length, smoothed [1/s]
        self._wind_y: float = 0.0
        self._air: float = 0.0  # airspeed
        self._tailwind: float = 0.0  # the wind along nose and b as they are at the sample
        self._crosswind: float = 0.0
        self._rest_forward: float = 0.0  # what the wind does not turn with
        self._rest_sideways: float = 0.0
        self._angle: float = 0.0  # from heading to course
        self._sample_speed: float = 0.0  # across the sphere, where `blown`

    def forget(self) -> None:
        """Restart with the next sample."""
        self.blown = False

    def observe(self, kite: "Estimator", airspeed: float) -> None:
        """Use a new sample of the `kite`, an estimate that flies with `airspeed` [m/s]."""
        self._angle = kite.course - kite.heading
        if not self._angle or kite.valid & _NEEDED != _NEEDED or kite.coasting:
            self.blown = False
            self._tailwind = self._crosswind = 0.0
            return
        speed = self._sample_speed = kite.sphere_speed()
        nose_up = cos(kite.heading)
        nose_across = sin(kite.heading)
        self._air = airspeed / kite.distance
        tailwind = speed * cos(self._angle) - self._air
        crosswind = speed * sin(self._angle)
        up = tailwind * nose_up - crosswind * nose_across
        across = tailwind * nose_across + crosswind * nose_up
        frame = kite.frame
        e1x = frame.e1x
        e1y = frame.e1y
        e2x = frame.e2x
        e2y = frame.e2y
        if self.blown and kite.interval > 0.0:
            share = kite.interval / (kite.interval + _SMOOTHING)
            wind_x = self._wind_x
            wind_y = self._wind_y
        else:
            share = 1.0
            wind_x = wind_y = 0.0
        self.blown = True
        square = frame.z * frame.z
        expected_up = wind_x * e1x + wind_y * e1y
        expected_across = wind_x * e2x + wind_y * e2y
        new_up = (up - expected_up) * share / (square if square > _LEAST_SQUARE else _LEAST_SQUARE)
        new_across = (across - expected_across) * share
        self._wind_x = wind_x + new_up * e1x + new_across * e2x
        self._wind_y = wind_y + new_up * e1y + new_across * e2y
        up = expected_up + new_up * square
        across = expected_across + new_across
        self._tailwind = up * nose_up + across * nose_across
        self._crosswind = across * nose_up - up * nose_across

    def begin(self, kite: "Estimator") -> None:
        """Go back to the newest sample of the `kite`."""
        speed = self.speed = self._sample_speed if self.blown else kite.sphere_speed()
        self.forward = speed
        self.sideways = 0.0
        if self._angle:
            self.forward = speed * cos(self._angle)
            self.sideways = speed * sin(self._angle)
        self._rest_forward = self.forward - self._tailwind
        self._rest_sideways = self.sideways - self._crosswind

    def turn(self, turned: float) -> None:
        """Update the velocity for a kite that has turned by `turned` [rad] since the sample."""
        along = cos(turned)
        beside = sin(turned)
        self.forward = self._rest_forward + self._tailwind * along + self._crosswind * beside
        self.sideways = self._rest_sideways + self._crosswind * along - self._tailwind * beside

    def end(self, turned: float) -> float:
        """Come to the end, turned by `turned` [rad]; return the angle from heading to course there."""
        self.turning_ratio = 1.0
        if not self.blown:
            return self._angle
        self.turn(turned)
        forward = self.forward
        sideways = self.sideways
        square = forward * forward + sideways * sideways
        self.speed = sqrt(square)
        share = self._air * forward  # over the speed squared: of the nose's turning that is the course's
        if share > 0.0:
            ratio = square / share
            self.turning_ratio = _LEAST_RATIO if ratio < _LEAST_RATIO else ratio if ratio < _MOST_RATIO else _MOST_RATIO
        return atan2(sideways, forward)
