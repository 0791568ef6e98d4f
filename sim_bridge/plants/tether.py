"""The tether: elastic segments from the ground point up, with drag and weight.

U. Fechner et al., "Dynamic model of a pumping kite power system" (2015), section 2: each segment is a spring and a
damper; its drag, on the flow perpendicular to it, is shared by its two ends. Point 0 is the lowest one above the
ground point, the last is where the kite hangs.
"""

from dataclasses import dataclass
from math import exp, sqrt

import numpy as np

from sim_bridge.compiled import compiled
from sim_bridge.plants.particles import GROUND, Points, Spring
from sim_bridge.plants.tether_settings import TetherSettings, line_length

GRAVITY = 9.81
_DENSITY_HEIGHT_M = 8550.0  # over which the density falls by a factor e; see air_density


@dataclass(frozen=True, kw_only=True)
class Tether(TetherSettings):
    """A tether of `length_m` [m], unstretched."""

    length_m: float = line_length()

    @classmethod
    def of(cls, settings: TetherSettings, length_m: float) -> "Tether":
        """The tether of these settings and this length [m]."""
        return cls(length_m=length_m, **vars(settings))

    @property
    def segment_m(self) -> float:
        """Unstretched length of a segment."""
        return self.length_m / self.segments

    def springs(self) -> list[Spring]:
        """The segments, from the ground up; segment i ends at point i."""
        length = self.segment_m
        return [Spring(i, i - 1 if i else GROUND, length, self.stiffness_n / length, self.damping_n_s / length,
                       self.compression) for i in range(self.segments)]

    def masses(self) -> Points:
        """Mass of each point (segments,), half a segment for the last."""
        masses = np.full(self.segments, self.segment_m * self.mass_kg_m)
        masses[-1] *= 0.5
        return masses

    def straight(self, end: Points) -> Points:
        """Points (segments, 3) on the straight line from the ground point to `end` (3,)."""
        return np.linspace(0.0, 1.0, self.segments + 1)[1:, None] * end


@compiled
def lower_density(density, depth):
    """Density of the air `depth` [m] below where it is `density`; depths beyond reason are taken for less."""
    return density * exp(min(1.0, depth / _DENSITY_HEIGHT_M))


@compiled
def add_tether_loads(x, v, segments, diameter, drag_coefficient, density, wind, out):
    """Add the drag [N] of the first `segments` segments in the uniform `wind` (3,) [m/s] to `out` (n, 3).

    0.5 rho c_d d l |w| w, w the part of the apparent wind at the segment's middle that is perpendicular to it, rho the
    density there; `density` is that at the upper end of the last of them.
    """
    top = x[segments - 1, 2]
    for i in range(segments):
        ex, ey, ez = x[i, 0], x[i, 1], x[i, 2]
        wx, wy, wz = wind[0] - 0.5 * v[i, 0], wind[1] - 0.5 * v[i, 1], wind[2] - 0.5 * v[i, 2]
        if i > 0:
            ex, ey, ez = ex - x[i - 1, 0], ey - x[i - 1, 1], ez - x[i - 1, 2]
            wx, wy, wz = wx - 0.5 * v[i - 1, 0], wy - 0.5 * v[i - 1, 1], wz - 0.5 * v[i - 1, 2]
        length = sqrt(ex * ex + ey * ey + ez * ez) + 1e-12
        ex, ey, ez = ex / length, ey / length, ez / length
        along = wx * ex + wy * ey + wz * ez
        wx, wy, wz = wx - along * ex, wy - along * ey, wz - along * ez
        local = lower_density(density, top - x[i, 2] + 0.5 * length * ez)
        half = 0.25 * local * drag_coefficient * diameter * length * sqrt(wx * wx + wy * wy + wz * wz)
        out[i, 0] += half * wx
        out[i, 1] += half * wy
        out[i, 2] += half * wz
        if i > 0:
            out[i - 1, 0] += half * wx
            out[i - 1, 1] += half * wy
            out[i - 1, 2] += half * wz
