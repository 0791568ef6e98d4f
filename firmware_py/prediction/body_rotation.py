"""Motion of a kite on the unit sphere: position gamma, nose h and b = gamma x h rotate as one rigid body."""

from math import atan2, cos, sin, sqrt

TYPE_CHECKING = False
if TYPE_CHECKING:
    from ..sphere import TangentFrame


class BodyRotation:
    """The rotation from where a flight began: a quaternion over the (gamma, h, b) of that place."""

    def __init__(self) -> None:
        self._w: float = 1.0
        self._x: float = 0.0
        self._y: float = 0.0
        self._z: float = 0.0

    def begin(self) -> None:
        """Reset to no rotation."""
        self._w = 1.0
        self._x = self._y = self._z = 0.0

    def turn(self, gamma: float, nose: float, side: float) -> None:
        """Rotate further by a rotation vector [rad], given in the body's present gamma, h and b."""
        half = 0.5 * sqrt(gamma * gamma + nose * nose + side * side)
        w = cos(half)
        share = 0.5 * sin(half) / half if half > 1e-6 else 0.5
        x = gamma * share
        y = nose * share
        z = side * share
        if self._w == 1.0:  # the first of them
            self._w = w
            self._x = x
            self._y = y
            self._z = z
            return
        w0 = self._w
        x0 = self._x
        y0 = self._y
        z0 = self._z
        self._w = w0 * w - x0 * x - y0 * y - z0 * z
        self._x = w0 * x + x0 * w + y0 * z - z0 * y
        self._y = w0 * y - x0 * z + y0 * w + z0 * x
        self._z = w0 * z + x0 * y - y0 * x + z0 * w

    def carry(self, start: "TangentFrame", heading: float, end: "TangentFrame") -> float:
        """Set `end` to where a kite from `start` (both frames) with `heading` [rad] arrives; return its heading."""
        up = cos(heading)
        across = sin(heading)
        w = self._w
        x = self._x
        y = self._y
        z = self._z
        ahead = 2.0 * (x * y + w * z)  # the new gamma over the old gamma, h and b
        beside = 2.0 * (x * z - w * y)
        above = 1.0 - 2.0 * (y * y + z * z)
        along_e1 = ahead * up - beside * across
        along_e2 = ahead * across + beside * up
        hz = up * start.e1z
        bz = -across * start.e1z
        tx = 2.0 * (z * hz - y * bz)  # straight up, in the body's axes: turned back by the rotation
        ty = 2.0 * (x * bz - z * start.z)
        tz = 2.0 * (y * start.z - x * hz)
        end.set_position(
            above * start.x + along_e1 * start.e1x + along_e2 * start.e2x,
            above * start.y + along_e1 * start.e1y + along_e2 * start.e2y,
            above * start.z + along_e1 * start.e1z)
        hz += w * ty + x * tz - z * tx
        bz += w * tz + y * tx - x * ty
        return atan2(-bz, hz)  # h is cos e1 + sin e2 of the heading, b is cos e2 - sin e1, and e2 is level
