"""The true state of a kite, as plants tell it."""

from math import atan2, sqrt

Vector = tuple[float, float, float]


class Truth:
    """Unit position and its velocity in the wind frame, angles [rad], SI units.

    `azimuth` and `elevation` follow from the position; the velocity is that of the unit position [1/s].
    """

    def __init__(self, position: Vector, velocity: Vector, course: float, heading: float, distance: float,
                 airspeed: float, tether_force: float) -> None:
        x, y, z = position
        self.position = position
        self.velocity = velocity
        self.azimuth = atan2(y, x)
        self.elevation = atan2(z, sqrt(x * x + y * y))
        self.course = course
        self.heading = heading
        self.distance = distance
        self.airspeed = airspeed
        self.tether_force = tether_force
