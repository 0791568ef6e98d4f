"""The flow around the wing, and its forces: a vortex lattice, in steady flow at every instant.

A horseshoe vortex lies in each panel: bound across it, its legs on the surface to the trailing edge, and from there
straight on along the onset flow. No flow goes through the control points, where each panel meets the wind less its own
velocity, rotation included. Forces are Kutta and Joukowski's, rho Gamma V cross l with the local velocity, on the
bound vortices and on the legs on the surface (J. Katz and A. Plotkin, "Low-Speed Aerodynamics", chapters 12 and 13).
Steering turns the sections' normals and leaves the vortices where they are: linear in the twist.

Potential flow has neither friction nor stall, and this one neither the air's inertia nor a wake with a history. Each
strip has a constant profile drag; the lift of a strip is kept below a greatest section lift coefficient, and the wake
within a cone about the chord, so that forces stay finite in any flow. The results are meant for attached flow: below
that lift, and at angles of sideslip below some 25 degrees.
"""

from math import cos, sqrt

import numpy as np
from numpy.typing import NDArray

from sim_bridge.plants.vortex_lattice.influence import of_rays, of_segments
from sim_bridge.plants.vortex_lattice.wing_geometry import Panels
from sim_bridge.plants.vortex_lattice.wing_loads import Solved, find_loads

Array = NDArray[np.float64]
_TURN_COSINE = cos(0.01)  # the wake is laid anew when the flow has turned by more than 0.01 rad
_CONE_TANGENT = 0.7  # the wake leaves at no more than 35 degrees to the chord
_LEAST_SPEED_M_S = 0.1


class WingFlow:
    """Forces on the lattice `panels`; `profile_drag` and `greatest_lift` are coefficients of a section.

    `wake` is where the wake leaves to, a unit vector; `circulation` (n,), `section_lift` (strips,), `forces` (k, 3) and
    `loads` (6,) are of the latest call of `find_loads`: see wing_loads.
    """

    def __init__(self, panels: Panels, profile_drag: float = 0.0, greatest_lift: float = 1e9):
        self.panels = panels
        self.profile_drag = profile_drag
        self.greatest_lift = greatest_lift
        nodes = panels.nodes
        bound = nodes[:-1, :-1].reshape(-1, 3), nodes[:-1, 1:].reshape(-1, 3)
        legs = nodes[:-1].reshape(-1, 3), nodes[1:].reshape(-1, 3)
        start, end = np.concatenate([bound[0], legs[0]]), np.concatenate([bound[1], legs[1]])
        share = np.concatenate([np.tile(panels.meeting, panels.rows), np.full(len(legs[0]), 0.5)])
        self._middle = start + share[:, None] * (end - start)
        self._points = np.concatenate([panels.control, self._middle])
        self._near = _of_near_field(panels, self._points, bound, legs)
        self._wash = np.concatenate([_wash(panels.control, panels.normal),
                                     _wash(panels.control, panels.normal_by_steering)], axis=1)
        self._onset = _onset(self._middle)
        self._cross_line = _cross_matrices(end - start)
        self.circulation = np.zeros(len(panels.control))
        self.section_lift = np.zeros(panels.strips)
        self.forces = np.zeros((len(start), 3))
        self.loads = np.zeros(6)
        self.wake = np.zeros(3)
        self.solved: Solved
        self.lay_wake(np.array([-1.0, 0.0, 0.0]))

    def lay_wake(self, direction: Array) -> None:
        """Let the wake leave along the unit vector `direction` (3,), and solve for all motions that may come."""
        panels = self.panels
        self.wake = direction
        rays = of_rays(self._points, panels.nodes[-1], direction)
        strips = self._near.reshape(-1, panels.rows, panels.strips, 3) + (rays[:, 1:] - rays[:, :-1])[:, None]
        induced = strips.reshape(self._near.shape)
        count = len(panels.control)
        through = np.einsum("pkc,pc->pk", induced[:count], panels.normal)
        strength = np.linalg.solve(through, -self._wash)
        velocity = (induced[count:].transpose(0, 2, 1).reshape(-1, count) @ strength).reshape(-1, 3, 12)
        velocity[:, :, :6] += self._onset
        self.solved = Solved(strength, self._cross_line @ velocity, self._middle, panels.strip_chord,
                             panels.strip_area, panels.strip_centre)

    def follow(self, velocity: Array) -> None:
        """Lay the wake along the onset flow `velocity` (3,), unless it lies there already."""
        size = sqrt(float(velocity @ velocity))
        if size < _LEAST_SPEED_M_S or float(velocity @ self.wake) > _TURN_COSINE * size:
            return
        direction = _in_cone(velocity / size)
        if float(direction @ self.wake) < _TURN_COSINE:
            self.lay_wake(direction)

    def find_loads(self, motion: Array, steering: float, density: float) -> Array:
        """Force [N] and moment about the origin [N m], (6,), in body axes.

        `motion` (6,) is the onset flow, the wind less the velocity of the origin [m/s], and the rotation of the wing
        [rad/s], both in body axes.
        """
        find_loads(self.solved, motion, steering, density, self.profile_drag, self.greatest_lift, self.circulation,
                   self.section_lift, self.forces, self.loads)
        return self.loads


def _of_near_field(panels: Panels, points: Array, bound: tuple[Array, Array], legs: tuple[Array, Array]) -> Array:
    """Velocities (p, n, 3) of the horseshoes without their wakes."""
    pieces = of_segments(points, *legs).reshape(-1, panels.rows, panels.strips + 1, 3)
    to_edge = np.cumsum(pieces[:, ::-1], axis=1)[:, ::-1]  # from each row to the trailing edge
    return of_segments(points, *bound) + (to_edge[:, :, 1:] - to_edge[:, :, :-1]).reshape(len(points), -1, 3)


def _onset(points: Array) -> Array:
    """Matrices (p, 3, 6) that make V - omega cross r of the motion, at `points` (p, 3)."""
    return np.concatenate([np.broadcast_to(np.eye(3), (len(points), 3, 3)), -_cross_matrices(points)], axis=2)


def _wash(points: Array, normal: Array) -> Array:
    """Matrix (p, 6) that makes the onset flow along `normal` (p, 3) of the motion."""
    return np.concatenate([normal, -np.cross(points, normal)], axis=1)


def _cross_matrices(vectors: Array) -> Array:
    """Matrices (p, 3, 3) that make w cross a of w, for `vectors` a (p, 3)."""
    x, y, z = vectors.T
    none = np.zeros_like(x)
    return np.stack([none, z, -y, -z, none, x, y, -x, none], axis=-1).reshape(-1, 3, 3)


def _in_cone(direction: Array) -> Array:
    """The nearest direction to the unit vector `direction` that is within the cone about the chord."""
    along = -float(direction[0])
    across = sqrt(max(0.0, 1.0 - along * along))
    if across <= _CONE_TANGENT * along:
        return direction
    side = _CONE_TANGENT / max(across, 1e-9) * direction[1:]
    return np.array([-1.0, side[0], side[1]]) / sqrt(1.0 + _CONE_TANGENT**2)
