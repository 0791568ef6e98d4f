"""Where a flight starts, and the straight lead-in before it, so that sensors and links are in use."""

from math import atan2, cos, exp, pi, sin, sqrt

import numpy as np

from kite_analysis.figure_eight import TargetEight
from sim_bridge.plants.truth import Truth, Vector
from sim_bridge.scenario.flight_settings import StartSettings

_LEAD_IN_RAD = 0.15


def start_position(settings: StartSettings, eight: TargetEight) -> tuple[Vector, Vector]:
    """Unit position and unit direction of the course at t = 0."""
    s = np.array([settings.path_parameter])
    gamma, = eight.position(s)
    along, _ = eight.derivatives(s)
    tangent = eight.direction * along[0]
    tangent /= np.linalg.norm(tangent)
    side = np.cross(gamma, tangent)
    offset, error = settings.offset_rad, settings.course_error_rad
    moved = cos(offset) * gamma + sin(offset) * side
    side = cos(offset) * side - sin(offset) * gamma
    course = cos(error) * tangent + sin(error) * side
    x, y, z = (float(v) for v in moved)
    hx, hy, hz = (float(v) for v in course)
    return (x, y, z), (hx, hy, hz)


def lead_in(start: Truth, time_s: float) -> Truth:
    """The kite at `time_s` < 0: on the great circle that reaches `start` at t = 0, at the speed it has there.

    Before, it comes up from rest, so that the whole way is _LEAD_IN_RAD long however much time there is.
    """
    velocity = vx, vy, vz = start.velocity
    speed = sqrt(vx * vx + vy * vy + vz * vz)  # not sum(): newer CPythons round it otherwise
    angle = _LEAD_IN_RAD * (exp(speed * time_s / _LEAD_IN_RAD) - 1.0)
    c, s = cos(angle), sin(angle)
    gamma = start.position
    x, y, z = (c * g + s * v / speed for g, v in zip(gamma, velocity, strict=True))
    vx, vy, vz = (c * v - s * speed * g for g, v in zip(gamma, velocity, strict=True))
    course = atan2(vx * y - vy * x, vz)
    heading = course + start.heading - start.course
    heading -= 2 * pi * round(heading / (2 * pi))
    return Truth((x, y, z), (vx, vy, vz), course, heading, start.distance, start.airspeed, start.tether_force)
