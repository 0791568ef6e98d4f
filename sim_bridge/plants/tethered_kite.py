"""Base of all plants on a segmented tether: wind, start, truth, crash."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from math import isfinite

import numpy as np

from sim_bridge.compiled import compiled
from sim_bridge.errors import ScenarioError
from sim_bridge.plants.particles import ParticleSystem, Points, Spring
from sim_bridge.plants.tether import Tether
from sim_bridge.plants.tethered_truth import truth_of
from sim_bridge.plants.truth import Truth, Vector
from sim_bridge.wind.air import Air
from sim_bridge.wind.profile import LAWS, air_on_tether
from sim_bridge.wind.wind import MeanWind
from sim_bridge.wind.wind_settings import WindSettings

_LEAST_HEIGHT_M = 0.5


class TetheredKite(ABC):
    """A particle system whose first points are the tether's; the kite's own come after them.

    Subclasses fill in the forces, and tell the state of the kite.
    """

    def __init__(self, tether: Tether, wind: WindSettings, step_s: float):
        self.step_s = step_s
        self.trouble: str | None = None
        self.tether = tether
        self._law = LAWS[wind.profile]
        self._exponent = wind.exponent
        self.steering = 0.0
        self.density = 0.0
        self.wind: Vector = 0.0, 0.0, 0.0  # at the kite [m/s]
        self.tether_wind: Vector = 0.0, 0.0, 0.0  # at half its height
        self.system: ParticleSystem

    def build(self, positions: Points, velocities: Points, masses: Points, springs: Sequence[Spring],
              air: Air) -> None:
        """Make the particle system, the kite in the wind `air`."""
        self.system = ParticleSystem(positions, velocities, masses, springs)
        self.feel(air)

    @abstractmethod
    def forces(self, x: Points, v: Points, out: Points) -> None:
        """Add all forces but the springs' to `out` (n, 3) [N]."""

    @abstractmethod
    def state(self) -> tuple[Vector, Vector, Vector]:
        """Position [m] and velocity [m/s] of the kite, and the direction of its nose.

        That need not be tangent to the sphere, nor of unit length.
        """

    def height(self) -> float:
        """Height of the kite [m]."""
        return self.state()[0][2]

    def kite_position(self) -> Points:
        """Where the kite is (3,) [m]."""
        return np.array(self.state()[0])

    def kite_velocity(self) -> Points:
        """How it moves (3,) [m/s]."""
        return np.array(self.state()[1])

    def nose(self) -> Points:
        """Direction of its nose (3,); see `state`."""
        return np.array(self.state()[2])

    def apparent_wind(self) -> Points:
        """Apparent wind at the kite (3,) [m/s]."""
        return self.wind - self.kite_velocity()

    def feel(self, air: Air) -> None:
        """Update wind and air density for the kite's height."""
        self.density, self.wind, self.tether_wind = air_on_tether(air, self._law, self._exponent, self.height())

    def step(self, dt: float, steering: float, air: Air) -> None:
        """Fly on by `dt` [s]; see Plant."""
        if self.trouble:
            return
        self.steering = steering
        self.feel(air)
        self.system.step(dt, self.forces)
        self._look_for_trouble()

    def truth(self) -> Truth:
        """See Plant."""
        return truth_of(*self.state(), self.wind, self.system.tension(0))

    def _look_for_trouble(self) -> None:
        height, x = self.height(), self.system.x
        if not isfinite(np.vdot(x, x)):  # the fastest way to ask all of them
            self.trouble = f"the integration diverged: a step of {self.step_s:g} s is too long"
        elif height < _LEAST_HEIGHT_M:
            wind = np.linalg.norm(self.wind)
            slack = ", tether slack" if self.system.tension(0) <= 0.0 else ""
            self.trouble = f"the kite crashed in {wind:.1f} m/s of wind{slack}"


def start_air(wind: WindSettings) -> Air:
    """The horizontal wind at t = 0 without its gusts.

    Raises:
        ScenarioError: there is a file for the wind, and something is wrong with it.
    """
    speed, direction, _ = MeanWind(wind).at(0.0)
    return Air(speed, direction)


def check_start_height(kind: str, height: float) -> None:
    """Refuse a start of the plant `kind` at a `height` [m] at or below the ground.

    Raises:
        ScenarioError: it is there.
    """
    if height < _LEAST_HEIGHT_M:
        raise ScenarioError(
            f"plant.kind = {kind}: the flight would start {height:.1f} m above the ground, which "
            f"takes {_LEAST_HEIGHT_M} m: raise EIGHT_ELEVATION, or start elsewhere")


def tangent_part(position: Points, direction: Points) -> Points:
    """The unit vector along `direction` (3,) that is tangent to the sphere at unit `position` (3,)."""
    tangent = direction - (direction @ position) * position
    return tangent / np.linalg.norm(tangent)


@compiled
def flies_on(x, height):
    """Whether all points `x` (n, 3) are finite and the kite's `height` [m] is no crash: no need to look for trouble."""
    squares = 0.0
    for point in range(len(x)):
        squares += x[point, 0] * x[point, 0] + x[point, 1] * x[point, 1] + x[point, 2] * x[point, 2]
    return isfinite(squares) and height >= _LEAST_HEIGHT_M
