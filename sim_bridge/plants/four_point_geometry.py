"""The four-point kite's shape: pod P, nose A, top B, tips C and D (left and right, seen from the ground), nine springs.

U. Fechner et al., "Dynamic model of a pumping kite power system" (2015), section 2.4, with the sizes of the
MIT-licensed KiteModels (KPS4).
"""

from typing import NamedTuple

import numpy as np

from sim_bridge.plants.four_point_settings import FourPointSettings
from sim_bridge.plants.particles import Points, Spring

POD, NOSE, TOP, LEFT, RIGHT = range(5)
_PAIRS = ((POD, NOSE), (LEFT, NOSE), (LEFT, RIGHT), (TOP, LEFT), (RIGHT, POD), (LEFT, POD), (TOP, RIGHT), (RIGHT, NOSE),
          (NOSE, TOP))
_SLACK = 0.9998  # unstretched over geometric length


class Shape(NamedTuple):
    """Sizes of the kite; see the settings of the same names."""

    height_m: float
    bridle_height_m: float
    width_m: float
    nose_distance: float
    mass_kg: float
    nose_share: float
    top_share: float
    stiffness_n: float
    damping_n_s: float
    compression: float
    extension_damping: float

    @classmethod
    def of(cls, settings: FourPointSettings) -> "Shape":
        """From the settings of the kite."""
        return cls(*(getattr(settings.kite if name == "mass_kg" else settings.four_point, name)
                     for name in cls._fields))

    def points(self, pod: Points, nose: Points, down: Points) -> Points:
        """Positions of A, B, C, D (4, 3); the unit vectors `nose` and `down`, the frame's x and z, are orthogonal."""
        middle = pod - self.bridle_height_m * down
        side = 0.5 * self.width_m * np.cross(down, nose)
        return np.array([middle + self.nose_distance * self.width_m * nose, middle - self.height_m * down,
                         middle + side, middle - side])

    def springs(self, pod: int) -> list[Spring]:
        """The nine springs of a kite whose pod is point number `pod`, and A to D those after it."""
        x, z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
        points = np.vstack((np.zeros(3), self.points(np.zeros(3), x, z)))
        springs = []
        for first, second in _PAIRS:
            length = _SLACK * float(np.linalg.norm(points[first] - points[second]))
            springs.append(Spring(pod + first, pod + second, length, self.stiffness_n / length,
                                  self.damping_n_s / length, self.compression, self.extension_damping))
        return springs

    def masses(self) -> Points:
        """Masses of A, B, C, D (4,) [kg]."""
        rest = (1.0 - self.nose_share) * self.mass_kg
        tip = 0.5 * (1.0 - self.top_share) * rest
        return np.array([self.nose_share * self.mass_kg, self.top_share * rest, tip, tip])
