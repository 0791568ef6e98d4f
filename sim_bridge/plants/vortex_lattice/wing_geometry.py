"""The wing as a surface: an arc of cambered sections, cut into panels.

Body axes: x towards the nose, z from the bridle point to the wing, y = z cross x, so that a positive rotation about z
is a positive turn of the heading. Strips are numbered from the tip at positive y, rows from the leading edge.
"""

from math import pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Surface(NamedTuple):
    """A wing by its sections, which are the edges of m strips; SI units and radians."""

    leading_edge: Array  # (m + 1, 3)
    chord: Array  # (m + 1, 3), from the leading to the trailing edge
    normal: Array  # (m + 1, 3) unit vectors
    camber: float  # height of the parabolic mean line over the chord
    steering_twist: Array  # (m + 1,), nose up, for full steering
    meeting: Array  # (m,): where across each strip the flow is met, as a share of its width


class Rows(NamedTuple):
    """Places of bound vortices and control points, as shares of the chord from the leading edge."""

    bound: Array  # (rows,)
    control: Array  # (rows,)

    @classmethod
    def cosine(cls, count: int) -> "Rows":
        """Those of C. E. Lan, "A quasi-vortex-lattice method in thin wing theory" (1974): exact for thin sections."""
        angle = pi / count * np.arange(count)
        return cls(0.5 - 0.5 * np.cos(angle + 0.5 * pi / count), 0.5 - 0.5 * np.cos(angle + pi / count))


class Panels(NamedTuple):
    """The lattice: n = rows * strips panels, row by row; SI units."""

    rows: int
    strips: int
    nodes: Array  # (rows + 1, strips + 1, 3): corners of the bound vortices, and of the trailing edge
    meeting: Array  # (strips,), as of the surface
    control: Array  # (n, 3)
    normal: Array  # (n, 3) of the mean line's slope at the control points
    normal_by_steering: Array  # (n, 3), its change for full steering, linear in the twist
    strip_chord: Array  # (strips,)
    strip_area: Array  # (strips,)
    strip_centre: Array  # (strips, 3), at the quarter chord


def panels(surface: Surface, rows: Rows) -> Panels:
    """`surface` with bound vortices and control points at the places `rows`."""
    nodes = _on_surface(surface, np.append(rows.bound, 1.0))
    line = _on_surface(surface, rows.control)
    control = line[:, :-1] + surface.meeting[:, None] * (line[:, 1:] - line[:, :-1])
    chord = 0.5 * (surface.chord[:-1] + surface.chord[1:])
    strip_chord = _sizes(chord)
    slope = 4.0 * surface.camber * (1.0 - 2.0 * rows.control)
    section_normal = 0.5 * (surface.normal[:-1] + surface.normal[1:])
    aft = chord / strip_chord[:, None] + slope[:, None, None] * section_normal
    aft /= _sizes(aft)[..., None]
    normal = np.cross(aft, line[:, 1:] - line[:, :-1])
    normal /= _sizes(normal)[..., None]
    twist = 0.5 * (surface.steering_twist[:-1] + surface.steering_twist[1:])
    quarter = _on_surface(surface, np.array([0.25]))[0]
    return Panels(
        len(rows.bound), len(twist), nodes, surface.meeting, control.reshape(-1, 3), normal.reshape(-1, 3),
        (twist[None, :, None] * aft).reshape(-1, 3), strip_chord,
        _sizes(np.cross(quarter[1:] - quarter[:-1], chord)), 0.5 * (quarter[:-1] + quarter[1:]))


def _on_surface(surface: Surface, share: Array) -> Array:
    """Points (k, m + 1, 3) on the sections' mean lines at the shares (k,) of the chord."""
    height = 4.0 * surface.camber * share * (1.0 - share)
    return (surface.leading_edge + share[:, None, None] * surface.chord
            + height[:, None, None] * _sizes(surface.chord)[:, None] * surface.normal)


def _sizes(vectors: NDArray[Any]) -> Array:
    return np.sqrt(np.sum(vectors * vectors, axis=-1))


class ArcWing(NamedTuple):
    """A kite's wing: a circular arc, seen from the front, whose chord and leading edge are parabolas along it.

    Lengths in metres, angles in radians. `bridle_height_m` is from the bridle point up to the top of the arc,
    `bridle_forward_m` from the bridle point forward to the leading edge at the centre. Steering twists the sections
    by `steering_twist_rad` times the sine of the span, from no twist at the centre to all of it at the tips.
    """

    span_m: float  # along the arc
    arc_rad: float  # from tip to tip
    root_chord_m: float
    tip_chord_m: float
    tip_sweep_m: float  # of the leading edge
    camber: float
    bridle_height_m: float
    bridle_forward_m: float
    steering_twist_rad: float

    @property
    def area_m2(self) -> float:
        """Area of the wing laid flat."""
        return self.span_m * (self.root_chord_m - (self.root_chord_m - self.tip_chord_m) / 3.0)

    def at(self, span: Array) -> tuple[Array, Array, Array]:
        """Leading edges (k, 3), chords (k,), and unit normals (k, 3) at `span` (k,), from 1 to -1 along the arc."""
        angle = 0.5 * self.arc_rad * span
        normal = np.stack([np.zeros_like(angle), np.sin(angle), np.cos(angle)], axis=-1)
        radius = self.span_m / self.arc_rad
        edge = radius * normal
        edge[:, 0] = self.bridle_forward_m - self.tip_sweep_m * span**2
        edge[:, 2] += self.bridle_height_m - radius
        return edge, self.root_chord_m - (self.root_chord_m - self.tip_chord_m) * span**2, normal

    def surface(self, strips: int, origin: Array) -> Surface:
        """The wing in `strips` strips, about `origin` (3,) as seen from the bridle point.

        The strips narrow towards the tips, and the flow is met where it is exact for an elliptic wing (Lan, 1974).
        """
        angle = pi / strips * np.arange(strips + 1)
        span, middle = np.cos(angle), np.cos(angle[:-1] + 0.5 * pi / strips)
        edge, chord, normal = self.at(span)
        return Surface(
            edge - origin, chord[:, None] * np.array([-1.0, 0.0, 0.0]), normal, self.camber,
            self.steering_twist_rad * np.sin(0.5 * pi * span), (span[:-1] - middle) / (span[:-1] - span[1:]))

    def masses(self, mass: float) -> tuple[Array, Array]:
        """Points (k, 3) about the bridle point, and masses (k,) that add up to `mass`: 55 % along the leading edge,
        as in an inflatable kite, the rest spread over the surface."""
        span = np.linspace(-0.9875, 0.9875, 80)  # middles of equal strips
        place = (np.arange(10) + 0.5) / 10.0
        edge, chord, _ = self.at(span)
        surface = edge[:, None] - (chord[:, None] * place)[..., None] * np.array([1.0, 0.0, 0.0])
        spread = np.repeat(chord / np.sum(chord), len(place)) / len(place)
        return (np.concatenate([edge, surface.reshape(-1, 3)]),
                mass * np.concatenate([np.full(len(span), 0.55 / len(span)), 0.45 * spread]))
