"""The steady flight at the start: straight over the sphere, with a straight tether and balanced forces."""

from math import cos, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim_bridge.plants.tether import GRAVITY
from sim_bridge.plants.vortex_lattice.wing_flow import WingFlow

Array = NDArray[np.float64]
_STEPS = 50


class Kite(NamedTuple):
    """What hangs at the end of the tether; the flow's origin is the wing's centre of mass."""

    flow: WingFlow
    centre: Array  # (3,) of mass, from the bridle point, body axes
    mass: float
    bridle_drag_m2: float  # drag coefficient times area, half at the wing and half at the bridle point
    tether_drag_m2: float  # the same of the tether, as felt at its end
    line_length: float


class SteadyFlight(NamedTuple):
    """`speed` through the air along the sphere, nose-up `pitch` from the sphere, and pull on the tether."""

    speed: float
    pitch: float
    pull: float


def steady_flight(kite: Kite, radial_wind: float, climb: float, height: float, density: float) -> SteadyFlight | None:
    """Steady flight by Newton's method, None if there is none.

    `radial_wind` [m/s] blows along the tether; `climb` and `height` are the vertical parts of the unit course and
    position. Unknown are speed and pitch, to balance the force along the course and the pitching moment about the
    bridle point. A tether that turns about its foot has a quarter of its drag at its end.
    """
    if radial_wind <= 0.0:
        return None
    unknown: Array = np.array([3.0 * radial_wind, 0.0])
    nudges = np.array([[0.01, 0.0], [0.0, 0.001]])
    for _ in range(_STEPS):
        residual = _balance(kite, unknown, radial_wind, climb, height, density)
        slope = np.stack([(_balance(kite, unknown + nudge, radial_wind, climb, height, density) - residual)[:2]
                          / np.max(nudge) for nudge in nudges], axis=1)
        determinant = slope[0, 0] * slope[1, 1] - slope[0, 1] * slope[1, 0]
        if not abs(determinant) > 0.0:
            return None
        change = np.linalg.solve(slope, -residual[:2])
        change *= min(1.0, 0.1 / (abs(change[1]) + 1e-9), 0.3 * unknown[0] / (abs(change[0]) + 1e-9))
        unknown += change
        if abs(change[0]) < 1e-3 and abs(change[1]) < 1e-4:
            return SteadyFlight(float(unknown[0]), float(unknown[1]), float(residual[2]))
    return None


def _balance(kite: Kite, unknown: Array, radial_wind: float, climb: float, height: float, density: float) -> Array:
    """Force along the course, pitching moment about the bridle point, and force along the tether."""
    speed, pitch = unknown
    onset = np.array([-speed, 0.0, radial_wind])  # along the course, across it, along the tether
    turn = np.array([[cos(pitch), 0.0, sin(pitch)], [0.0, 1.0, 0.0], [-sin(pitch), 0.0, cos(pitch)]])  # to body axes
    motion = np.concatenate([turn @ onset, [0.0, speed / kite.line_length, 0.0]])
    kite.flow.follow(motion[:3])
    loads = kite.flow.find_loads(motion, 0.0, density)
    pressure = 0.5 * density * sqrt(speed * speed + radial_wind * radial_wind) * onset
    at_the_wing = 0.5 * kite.bridle_drag_m2 * pressure - GRAVITY * kite.mass * np.array([climb, 0.0, height])
    moment = loads[3:] + np.cross(kite.centre, loads[:3] + turn @ at_the_wing)
    force = turn.T @ loads[:3] + at_the_wing + (0.5 * kite.bridle_drag_m2 + kite.tether_drag_m2) * pressure
    return np.array([force[0], moment[1], force[2]])
