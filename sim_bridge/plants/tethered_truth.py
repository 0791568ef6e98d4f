"""The truth about a kite on a tether, from where it is and how it moves; compiled with the loop, so no numpy here."""

from math import atan2, sqrt

from sim_bridge.plants.truth import Truth, Vector


def truth_of(position: Vector, velocity: Vector, nose: Vector, wind: Vector, tension: float) -> Truth:
    """The truth about a kite at `position` [m] with `velocity` [m/s], in `wind` [m/s] and under `tension` [N].

    That is the tension of the tether's lowest segment. `nose` is the direction of the kite's nose, of any length, and
    need not be tangent to the sphere.
    """
    x, y, z = position
    distance = sqrt(x * x + y * y + z * z)
    x, y, z = x / distance, y / distance, z / distance
    gamma = x, y, z
    vx, vy, vz = velocity
    away = vx * x + vy * y + vz * z
    rate = (vx - away * x) / distance, (vy - away * y) / distance, (vz - away * z) / distance
    ax, ay, az = wind[0] - vx, wind[1] - vy, wind[2] - vz
    return Truth(gamma, rate, _turning_angle(gamma, rate), _turning_angle(gamma, nose), distance,
                 sqrt(ax * ax + ay * ay + az * az), max(0.0, tension))


def _turning_angle(gamma: Vector, direction: Vector) -> float:
    x, y, z = gamma
    dx, dy, dz = direction
    return atan2(dx * y - dy * x, dz - (dx * x + dy * y + dz * z) * z)
