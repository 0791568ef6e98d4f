"""A kite in potential flow on a segmented tether.

The wing is a vortex lattice. It is rigid, and hangs by its bridle from the tether's last point: four points that have
its mass and inertia, held together and to the bridle point by springs. Airspeed, angle of attack, sideslip, roll, yaw
damping and the turning-rate constant result from the flow.
"""

from math import ceil, cos, radians, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from sim_bridge.errors import ScenarioError
from sim_bridge.plants.particles import Points
from sim_bridge.plants.tether import GRAVITY, Tether, add_tether_loads
from sim_bridge.plants.tethered_kite import TetheredKite, tangent_part
from sim_bridge.plants.truth import Vector
from sim_bridge.plants.vortex_lattice.steady_flight import Kite, SteadyFlight, steady_flight
from sim_bridge.plants.vortex_lattice.wing_flow import WingFlow
from sim_bridge.plants.vortex_lattice.wing_geometry import ArcWing, Rows, panels
from sim_bridge.plants.vortex_lattice.wing_points import (
    NOSE,
    TAIL,
    add_bridle_drag,
    find_pose,
    four_points,
    frame_springs,
    share_out,
)
from sim_bridge.plants.vortex_lattice.wing_settings import VortexLatticeSettings, WingSettings
from sim_bridge.wind.air import Air
from sim_bridge.wind.profile import air_density, wind_at
from sim_bridge.wind.wind_settings import WindSettings

Array = NDArray[np.float64]
STEP_S = 0.004  # half of it changes a turn of 3 s by 0.1 % of its way; the error grows with the springs' stiffness
_STIFFNESS_N_M = 4e4  # of lines of 2 mm and 4 m, as in a bridle: EA = 170 kN
_DAMPING_N_S_M = 20.0  # some 7 % of the critical one


class VortexLatticeKite(TetheredKite):
    """See the module. `flow` is the flow around the wing, `motion` (6,) how the wing meets it: see WingFlow."""

    def __init__(self, settings: VortexLatticeSettings, wind: WindSettings, position: Vector, direction: Vector):
        super().__init__(Tether.of(settings.tether, settings.line_length_m), wind, min(STEP_S, settings.step_s))
        wing = settings.wing
        arc = arc_wing(wing)
        corners, self._axes, self.centre = four_points(*arc.masses(wing.mass_kg))
        self.flow = WingFlow(panels(arc.surface(wing.strips, self.centre), Rows.cosine(wing.rows)),
                             wing.profile_drag, wing.greatest_lift)
        self._point_mass = 0.25 * wing.mass_kg
        self._bridle_drag_m2 = wing.bridle_drag_m2
        self._masses = np.concatenate([self.tether.masses(), np.full(4, self._point_mass)])
        self._masses[self.tether.segments - 1] += wing.pod_mass_kg
        self.frame, self.pose, self.motion = np.eye(3), np.zeros((4, 3)), np.zeros(6)
        self._set_off(Air(wind.speed_m_s), np.array(position), np.array(direction), corners)

    def step(self, dt: float, steering: float, air: Air) -> None:
        """Fly on by `dt` [s], in steps no longer than `step_s`; see Plant."""
        steps = max(1, ceil(dt / self.step_s - 1e-6))
        for _ in range(steps):
            self.flow.follow(self.motion[:3])
            super().step(dt / steps, steering, air)

    def forces(self, x: Points, v: Points, out: Points) -> None:
        first, tether = self.tether.segments, self.tether
        out[:, 2] -= GRAVITY * self._masses
        add_tether_loads(x, v, first, tether.diameter_m, tether.drag_coefficient, self.density, self.tether_wind, out)
        find_pose(x[first:], v[first:], self._point_mass, self._axes, self.wind, self.frame, self.pose, self.motion)
        loads = self.flow.find_loads(self.motion, self.steering, self.density)
        share_out(x[first:], self._point_mass, self.frame, self.pose, loads, out[first:])
        add_bridle_drag(v[first - 1:], self.wind, 0.5 * self.density * self._bridle_drag_m2, out[first - 1:])

    def state(self) -> tuple[Vector, Vector, Vector]:
        """Position and velocity of the wing's centre of mass, and the way from its tail to its nose."""
        x, v = self.system.x[-4:].tolist(), self.system.v[-4:].tolist()
        (nx, ny, nz), (tx, ty, tz) = x[NOSE], x[TAIL]
        return _mean(x), _mean(v), (nx - tx, ny - ty, nz - tz)

    def height(self) -> float:
        """See TetheredKite."""
        return _mean(self.system.x[-4:].tolist())[2]

    def _set_off(self, air: Air, position: Array, direction: Array, corners: Array) -> None:
        """Place everything as in steady flight along `direction`: the tether straight, all turning about its foot."""
        course = tangent_part(position, direction)
        height = (self.tether.length_m + self.centre[2]) * position[2]
        self.density = air_density(height)
        self.wind = wind_at(air, self._law, self._exponent, height)
        flight = self._steady_flight(position, course)
        drift = self.wind - (self.wind @ position) * position
        side = np.cross(position, course)
        sine = min(0.9, max(-0.9, -float(drift @ side) / flight.speed))
        nose = sqrt(1.0 - sine * sine) * course + sine * side
        along = float(drift @ course) + flight.speed * sqrt(1.0 - sine * sine)
        c, s = cos(flight.pitch), sin(flight.pitch)
        frame = np.stack([c * nose + s * position, np.cross(position, nose), c * position - s * nose])
        end = self.tether.length_m * (1.0 + flight.pull / self.tether.stiffness_n) * position
        positions = np.concatenate([self.tether.straight(end), end + (self.centre + corners) @ frame])
        rate = along / float(np.linalg.norm(end + self.centre @ frame))
        velocities = rate * np.cross(np.cross(position, course), positions)
        last = self.tether.segments - 1
        springs = self.tether.springs() + frame_springs(positions, last, _STIFFNESS_N_M, _DAMPING_N_S_M)
        self.build(positions, velocities, self._masses, springs, air)
        find_pose(positions[last + 1:], velocities[last + 1:], self._point_mass, self._axes, self.wind, self.frame,
                  self.pose, self.motion)

    def _steady_flight(self, position: Array, course: Array) -> SteadyFlight:
        tether = self.tether
        tether_drag_m2 = 0.25 * tether.drag_coefficient * tether.diameter_m * tether.length_m
        kite = Kite(self.flow, self.centre, 4.0 * self._point_mass, self._bridle_drag_m2, tether_drag_m2,
                    tether.length_m)
        radial = float(self.wind @ position)
        flight = steady_flight(kite, radial, course[2], position[2], self.density)
        if flight is None or flight.pull <= 0.0:
            raise ScenarioError(
                f"plant.kind = vortex-lattice: the kite cannot fly steadily at the start of the flight, where "
                f"{radial:.1f} m/s of wind blow along the tether; start lower or in more wind, or check the keys "
                f"of the section wing")
        return flight


def arc_wing(wing: WingSettings) -> ArcWing:
    """The wing of these settings."""
    sizes = {name: getattr(wing, name) for name in ArcWing._fields if name != "steering_twist_rad"}
    return ArcWing(**sizes, steering_twist_rad=radians(wing.steering_twist_deg))


def _mean(points: list[list[float]]) -> Vector:
    (ax, ay, az), (bx, by, bz), (cx, cy, cz), (dx, dy, dz) = points
    return 0.25 * (ax + bx + cx + dx), 0.25 * (ay + by + cy + dy), 0.25 * (az + bz + cz + dz)
