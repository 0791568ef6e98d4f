"""A kite of four points on a segmented tether, whose heading comes from the forces on its tips.

The four-point model of U. Fechner et al., "Dynamic model of a pumping kite power system" (2015), section 2.4, with the
numbers of the MIT-licensed KiteModels (KPS4). The kite is where the centre of mass of nose, top and tips is; its nose
points along the x axis of the kite frame.
"""

from math import asin, atan2, ceil, degrees, sqrt

import numpy as np

from sim_bridge.errors import ScenarioError
from sim_bridge.plants.four_point_forces import Sizes, add_forces, advance, kite_state, tips_and_top
from sim_bridge.plants.four_point_geometry import Shape
from sim_bridge.plants.four_point_settings import FourPointSettings
from sim_bridge.plants.particles import Points
from sim_bridge.plants.polars import coefficient
from sim_bridge.plants.tether import GRAVITY, Tether
from sim_bridge.plants.tethered_kite import TetheredKite, check_start_height, start_air, tangent_part
from sim_bridge.plants.truth import Vector
from sim_bridge.wind.air import Air
from sim_bridge.wind.wind_settings import WindSettings

_GIVEN_STEP_S = 0.02  # a step of the plant; it is integrated in as many as it takes
_DAMPING_STEPS = 2.5  # most damping rate times step of the lightest point in the air, for accuracy
_STIFF_STEPS = 40.0  # most h^2 k / m of a tether segment, see particles
_LEAST_STEP_S = 2e-4  # no shorter for those two: it has to end some day
_TRIM_S = (1.0, 12.0)  # shortest and longest time for the start to settle
_TRIM_CHANGE = 1e-4  # of the velocity in a tick, over the airspeed, at which it has
_FIRST_GLIDE = 3.0  # speed over the wind along the tether that the trim begins with
_LEAST_PULL = 0.1  # of the tether on the ground, over the weight, for a flight to begin
_LEAST_SPEED_M_S = 0.3
_COLLAPSED, _BURST = 0.4, 3.0  # of the distance between the tips, or from them up to the top


class FourPointKite(TetheredKite):
    """The tether's last point is the control pod; nose, top, left tip and right tip come after it.

    Raises:
        ScenarioError: it cannot fly there, or its sizes do not match.
    """

    def __init__(self, settings: FourPointSettings, wind: WindSettings, position: Vector, direction: Vector):
        super().__init__(Tether.of(settings.tether, settings.line_length_m), wind, _GIVEN_STEP_S)
        self.shape = Shape.of(settings)
        self.sizes = Sizes.of(settings)
        if self.sizes.side_area >= 1.0:
            raise ScenarioError(f"kite.side_area = {self.sizes.side_area:g} is below 1 for the four-point kite")
        self._first = self.tether.segments
        kite_masses = self.shape.masses()
        self._shares = kite_masses / np.sum(kite_masses)
        self._storage = self.sizes.storage()
        slopes = np.diff([coefficient(self.sizes.lift, angle) for angle in np.radians(np.arange(-180.0, 180.0))])
        light = max(1.0 / kite_masses[1], self.sizes.side_area / kite_masses[2])
        self._damping = 0.5 * self.sizes.area_m2 * float(np.max(np.abs(slopes))) / np.radians(1.0) * light
        tether = self.tether
        node_kg, stiffness = tether.segment_m * tether.mass_kg_m, tether.stiffness_n / tether.segment_m
        self._longest_s = min(settings.step_s, max(_LEAST_STEP_S, sqrt(_STIFF_STEPS * node_kg / stiffness)))
        gamma, course = np.array(position), np.array(direction)
        masses = np.concatenate([self.tether.masses(), kite_masses])
        masses[self._first - 1] += settings.kite.pod_mass_kg
        check_start_height("four-point", settings.line_length_m * float(gamma[2]))
        air = start_air(wind)
        points = self._laid_out(gamma, course)
        self.build(points, np.zeros_like(points), masses, self.tether.springs() + self.shape.springs(self._first - 1),
                   air)
        self._trim(gamma, course, air)

    def forces(self, x: Points, v: Points, out: Points) -> None:
        """See TetheredKite."""
        add_forces(x, v, self.system.masses, self.system.ends, -self.steering, self.density, self.wind,
                   self.tether_wind, self.sizes, out)

    def step(self, dt: float, steering: float, air: Air) -> None:
        """Fly on by `dt` [s]; see Plant. The faster the air, the shorter the steps of the integration.

        The model's own steering turns negatively: it pulls the left tip outwards.
        """
        if self.trouble:
            return
        self.steering = steering
        self.feel(air)
        _, (vx, vy, vz), _ = self.state()
        wx, wy, wz = self.wind
        ax, ay, az = wx - vx, wy - vy, wz - vz
        damping = self._damping * self.density * sqrt(ax * ax + ay * ay + az * az)
        rate = max(1.0 / self._longest_s, min(1.0 / _LEAST_STEP_S, damping / _DAMPING_STEPS))
        steps = max(1, ceil(dt * rate - 1e-6))
        advance(dt / steps, steps, -steering, self.density, self.wind, self.tether_wind, *self._storage,
                *self.system.storage)
        self._look_for_trouble()

    def state(self) -> tuple[Vector, Vector, Vector]:
        """See TetheredKite."""
        return kite_state(self.system.x, self.system.v, self._first, self._shares)

    def _look_for_trouble(self) -> None:
        shape = self.shape
        span, height = tips_and_top(self.system.x, self._first)
        if not (span < _BURST * shape.width_m and abs(height) < _BURST * shape.height_m):  # NaN, too
            self.trouble = "the integration diverged: the kite's masses, areas and stiffnesses do not match"
        elif span < _COLLAPSED * shape.width_m:
            self.trouble = f"the kite collapsed: its tips are {span:.1f} m apart, not {shape.width_m:.1f} m"
        elif height < _COLLAPSED * shape.height_m:
            self.trouble = f"the kite collapsed: its top is {height:.1f} m above its tips, not {shape.height_m:.1f} m"
        else:
            super()._look_for_trouble()

    def _laid_out(self, gamma: Points, course: Points) -> Points:
        """All points, the tether straight towards `gamma`, the nose in the direction `course`."""
        pod = self.tether.length_m * gamma
        return np.vstack((self.tether.straight(pod), self.shape.points(pod, course, -gamma)))

    def _trim(self, gamma: Points, course: Points, air: Air) -> None:
        """Bring the kite into quasi-steady flight at `gamma`, on the tangent `course`.

        It flies, and after each tick everything is turned about the ground point so that the kite is at `gamma` on
        `course` again: what comes out is flight at a speed, an attitude and a stretch that stay.
        """
        x, v = self.system.x, self.system.v
        tangential = self.wind - (self.wind @ gamma) * gamma
        speed = _FIRST_GLIDE * max(_LEAST_SPEED_M_S, float(self.wind @ gamma))
        x[:] = self._laid_out(gamma, tangent_part(gamma, speed * course - tangential))
        v[:] = np.cross(speed / self.tether.length_m * np.cross(gamma, course), x)
        time_s, change = 0.0, 1.0
        while not self.trouble and (time_s < _TRIM_S[0] or change > _TRIM_CHANGE) and time_s < _TRIM_S[1]:
            before = self.kite_velocity()
            self.step(_GIVEN_STEP_S, 0.0, air)
            turn = _turn_to(self.kite_position(), self.kite_velocity(), gamma, course)
            x[:], v[:] = x @ turn.T, v @ turn.T
            difference, apparent = self.kite_velocity() - before, self.apparent_wind()
            change = sqrt(float(difference @ difference) / (float(apparent @ apparent) + 1e-9))
            time_s += _GIVEN_STEP_S
        reason = self.trouble
        lift, pull, weight = self._air_force(), self.system.tension(0), GRAVITY * float(np.sum(self.system.masses))
        if not reason and (lift < weight or pull < _LEAST_PULL * weight):
            reason = f"lift and drag are {lift:.0f} N, the weight {weight:.0f} N, the tether force {pull:.0f} N"
        elif not reason and (self.kite_velocity() @ course < _LEAST_SPEED_M_S or self.nose() @ course < 0.0):
            reason = "it makes no headway"
        if reason:
            azimuth, elevation = degrees(atan2(gamma[1], gamma[0])), degrees(asin(gamma[2]))
            raise ScenarioError(
                f"plant.kind = four-point: it cannot fly at azimuth {azimuth:.0f} deg, elevation {elevation:.0f} deg, "
                f"in {np.linalg.norm(self.wind):.1f} m/s of wind: {reason}")

    def _air_force(self) -> float:
        """Size of lift and drag of the kite [N]."""
        forces = np.zeros_like(self.system.x)
        self.forces(self.system.x, self.system.v, forces)
        forces[:, 2] += GRAVITY * self.system.masses
        return float(np.linalg.norm(np.sum(forces[self._first :], axis=0)))


def _turn_to(position: Points, velocity: Points, gamma: Points, course: Points) -> Points:
    """The rotation (3, 3) that brings `position` to the direction `gamma` and `velocity` to the tangent `course`."""
    here = position / np.linalg.norm(position)
    along = tangent_part(here, velocity)
    return np.column_stack((gamma, course, np.cross(gamma, course))) @ np.vstack((here, along, np.cross(here, along)))
