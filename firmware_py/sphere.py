"""Angles on the unit sphere, in forms that survive float32 (atan2, never acos).

Wind frame: x downwind, z up, y completes a right-handed set. At a unit position gamma, e1 points up along the
meridian and e2 = gamma x e1; the turning angle is measured from e1 towards e2.
"""

from math import atan2, cos, pi, sin, sqrt

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

TWO_PI = 2 * pi  # type: Final
_LEVEL = 1e-6  # type: Final  # so near to the zenith there is no azimuth [rad]


def wrap(angle: float) -> float:
    """`angle` [rad] brought into (-pi, pi]; written out where each tick needs it."""
    angle %= TWO_PI
    return angle - TWO_PI if angle > pi else angle


class TangentFrame:
    """A unit position with its tangent plane: x, y, z, and the components of e1 and e2 (e2 has no z).

    Set from azimuth and elevation, so that e1 stays defined by the azimuth even at the zenith.
    """

    x: float
    y: float
    z: float
    e1x: float
    e1y: float
    e1z: float
    e2x: float
    e2y: float

    def __init__(self) -> None:
        self.set(0.0, 0.0)

    def set(self, azimuth: float, elevation: float) -> None:
        """Move to `azimuth` and `elevation` [rad]."""
        cos_azimuth = cos(azimuth)
        sin_azimuth = sin(azimuth)
        cos_elevation = cos(elevation)
        sin_elevation = sin(elevation)
        self.x = cos_elevation * cos_azimuth
        self.y = cos_elevation * sin_azimuth
        self.z = sin_elevation
        self.e1x = -sin_elevation * cos_azimuth
        self.e1y = -sin_elevation * sin_azimuth
        self.e1z = cos_elevation
        self.e2x = sin_azimuth
        self.e2y = -cos_azimuth

    def set_position(self, x: float, y: float, z: float) -> None:
        """Move to a unit position; straight above, the azimuth stays."""
        self.x = x
        self.y = y
        self.z = z
        level = self.e1z = sqrt(x * x + y * y)
        if level > _LEVEL:
            self.e2x = y / level
            self.e2y = -x / level
        self.e1x = z * self.e2y
        self.e1y = -z * self.e2x

    def up(self, x: float, y: float, z: float) -> float:
        """Component along e1 of a vector."""
        return self.e1x * x + self.e1y * y + self.e1z * z

    def across(self, x: float, y: float) -> float:
        """Component along e2 of a vector, which needs its x and y only."""
        return self.e2x * x + self.e2y * y

    def distance_to(self, x: float, y: float, z: float) -> float:
        """Great-circle distance [rad] to a unit vector."""
        up = self.up(x, y, z)
        across = self.across(x, y)
        return atan2(sqrt(up * up + across * across), self.x * x + self.y * y + self.z * z)
