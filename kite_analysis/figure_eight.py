"""The figure of eight on the unit sphere, for numpy: positions, tangents, and the nearest point.

Azimuth = centre + A sin s, elevation = centre + B sin 2s; frames and signs as everywhere: x downwind, z up, turning
angle from straight up towards gamma x up.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
_COARSE = 256
_REFINEMENTS = 4


def unit_position(azimuth: Array, elevation: Array) -> Array:
    """Unit vectors (n, 3) in the wind frame from azimuth and elevation [rad], each (n,)."""
    return np.stack(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], axis=-1)


def turning_angle(position: Array, direction: Array) -> Array:
    """Turning angle [rad] of tangent vectors `direction` (n, 3) at unit positions (n, 3)."""
    across = direction[..., 0] * position[..., 1] - direction[..., 1] * position[..., 0]
    return np.arctan2(across, direction[..., 2])


class TargetEight(NamedTuple):
    """An eight: angles in radians, `direction` of flight along s is +1 or -1."""

    azimuth: float
    elevation: float
    half_width: float
    half_height: float
    direction: float = 1.0

    @classmethod
    def from_parameters(cls, value: Callable[[str], float]) -> "TargetEight":
        """From the firmware's parameters, which `value(name)` gives in degrees."""

        def radians(name: str) -> float:
            return float(np.radians(value(name)))

        return cls(radians("EIGHT_AZIMUTH"), radians("EIGHT_ELEVATION"), radians("EIGHT_HALF_W"),
                   radians("EIGHT_HALF_H"), value("EIGHT_DIRECTION"))

    def angles(self, s: Array) -> tuple[Array, Array]:
        """Azimuth and elevation [rad] at path parameters `s`."""
        return self.azimuth + self.half_width * np.sin(s), self.elevation + self.half_height * np.sin(2 * s)

    def position(self, s: Array) -> Array:
        """Unit vectors (n, 3) at path parameters `s` (n,)."""
        return unit_position(*self.angles(s))

    def derivatives(self, s: Array) -> tuple[Array, Array]:
        """First and second derivative of the position by `s`, each (n, 3)."""
        sin_s, cos_s = np.sin(s), np.cos(s)
        azimuth = self.azimuth + self.half_width * sin_s
        elevation = self.elevation + 2 * self.half_height * sin_s * cos_s
        azimuth_rate, elevation_rate = self.half_width * cos_s, 2 * self.half_height * (1 - 2 * sin_s * sin_s)
        east, north, level, up = np.sin(azimuth), np.cos(azimuth), np.cos(elevation), np.sin(elevation)
        rise = up * elevation_rate  # how fast the level part shrinks
        around = level * azimuth_rate
        squares = level * (azimuth_rate * azimuth_rate + elevation_rate * elevation_rate)
        second_rate = -8 * self.half_height * sin_s * cos_s  # of the elevation
        inward = squares + up * second_rate
        aside = level * self.half_width * sin_s + 2 * rise * azimuth_rate
        return (
            np.stack([-rise * north - around * east, around * north - rise * east, level * elevation_rate], axis=-1),
            np.stack([aside * east - inward * north, -aside * north - inward * east,
                      level * second_rate - rise * elevation_rate], axis=-1))

    def course(self, s: Array) -> Array:
        """Turning angle [rad] of the flight along the curve at `s`."""
        return turning_angle(self.position(s), self.direction * self.derivatives(s)[0])

    def nearest(self, position: Array) -> tuple[Array, Array]:
        """Path parameter of the nearest point, and the great-circle distance [rad] to it, for positions (n, 3)."""
        strands, distances = self.nearest_of_strands(position)
        first = distances[0] <= distances[1]
        return np.where(first, *strands), np.where(first, *distances)

    def nearest_of_strands(self, position: Array) -> tuple[Array, Array]:
        """Path parameter (2, n) of the nearest point of each of the two strands that cross, and the distance to it.

        It is the best of 128 points, refined by Newton's method on the cosine of the distance.
        """
        grid = (np.arange(_COARSE) / _COARSE - 0.25) * 2 * np.pi
        strands = np.stack([self._nearest_of(position, half) for half in np.split(grid, 2)])
        return strands, np.stack([great_circle_distance(position, self.position(s)) for s in strands])

    def _nearest_of(self, position: Array, grid: Array) -> Array:
        """Path parameter of the nearest point to each position, starting from the best of `grid`."""
        s = grid[np.argmax(position @ self.position(grid).T, axis=1)]
        for _ in range(_REFINEMENTS):
            first, second = self.derivatives(s)
            slope = np.sum(position * first, axis=-1)
            curvature = -np.sum(position * second, axis=-1)
            step = slope / np.where(curvature > 1e-6, curvature, np.inf)
            s = s + np.clip(step, -np.pi / _COARSE, np.pi / _COARSE)
        return s


def great_circle_distance(first: Array, second: Array) -> Array:
    """Angle [rad] between unit vectors (n, 3), exact for small angles too."""
    return np.arctan2(np.linalg.norm(np.cross(first, second), axis=-1), np.sum(first * second, axis=-1))
