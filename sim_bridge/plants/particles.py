"""Point masses joined by stiff springs and dampers, and an integration method for them.

The method is ROS2 of J. G. Verwer et al., "A second-order Rosenbrock method applied to photochemical dispersion
problems" (1999), a W-method: second order with any Jacobian, and L-stable. Springs and dampers are in the Jacobian,
all other forces are taken as they are: the step is limited by the flow, not by the stiffness of the lines. With
position x, velocity v, mass M, spring stiffness K and damping C (as derivatives of the force), g = 1 - 1/sqrt(2):

    (M - g h C - g^2 h^2 K) q1 = F(x, v) + g h K v                              p1 = v + g h q1
    (M - g h C - g^2 h^2 K) q2 = F(x + h p1, v + h q1) - 2 M q1 + g h K (v + h q1 - 2 p1)
                                                                               p2 = v + h q1 - 2 p1 + g h q2
    x += 3/2 h p1 + 1/2 h p2                                                    v += 3/2 h q1 + 1/2 h q2

It is second order as long as h^2 k / m of the stiffest spring k on the lightest mass m stays below some 40; beyond,
accuracy goes, not stability. The tension of a line of length l that swings with speed v is wrong by some 0.1 k (h
v)^2 / l. Where a spring is in compression its geometric stiffness is left out, so that the matrix stays positive
definite; and the matrix has the larger stiffness and damping of each spring, in tension or compression, so that one
that tightens within a step finds them there.
"""

from collections.abc import Callable, Sequence
from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim_bridge.compiled import compiled
from sim_bridge.plants.envelope_cholesky import envelope, factor, solve

Points = NDArray[np.float64]
Forces = Callable[[Points, Points, Points], None]  # (positions, velocities, out): adds to `out` (n, 3) [N]

GROUND = -1  # the fixed point at the origin, as an end of a spring
_GAMMA = 1.0 - 1.0 / sqrt(2.0)


class Spring(NamedTuple):
    """A line or strut between the points `first` and `second` (an index, or GROUND); SI units."""

    first: int
    second: int
    length: float  # unstretched
    stiffness: float  # [N/m]
    damping: float  # [N s/m]
    compression: float = 1.0  # share of the stiffness left in compression
    extension_damping: float = 1.0  # factor on the damping in extension


class Storage(NamedTuple):
    """All that a step works on, as compiled code takes it: array by array, since a tuple costs it 1 us a call."""

    points: Points  # (7, n, 3), see POSITIONS to V2
    masses: Points  # (n,)
    ends: NDArray[np.int64]  # (springs, 2)
    springs: Points  # (springs, 5), the rest of Spring
    starts: NDArray[np.int64]  # (n,), the matrix's envelope
    matrix: Points
    lines: Points  # (springs, 6), of the first stage: direction, tension over length, stiffness, damping
    air_damping: Points  # (n, 3, 3), what the outer forces lose by each point's velocity, symmetric; 0 is good, too


POSITIONS, VELOCITIES = 0, 1  # in Storage.points
P1, Q1 = 2, 3  # the first stage takes its forces in Q1,
X2, V2 = 4, 5  # the second one is at these positions and velocities
FORCES2 = 6  # and takes its forces here


class ParticleSystem:
    """State: positions `x` and velocities `v`, (n, 3) each, in the wind frame.

    `step` suits forces in plain Python; compiled ones call `first_stage` and `second_stage` with the `storage`.
    """

    def __init__(self, positions: Points, velocities: Points, masses: Points, springs: Sequence[Spring]):
        count = len(masses)
        ends = np.array([spring[:2] for spring in springs], dtype=np.int64)
        self.storage = Storage(
            np.zeros((7, count, 3)), np.array(masses, dtype=np.float64), ends,
            np.array([spring[2:] for spring in springs], dtype=np.float64), envelope(count, ends),
            np.zeros((3 * count, 3 * count)), np.zeros((len(springs), 6)), np.zeros((count, 3, 3)))
        points, self.masses, self.ends, self.springs, *_ = self.storage
        points[POSITIONS], points[VELOCITIES] = positions, velocities
        self.x, self.v = points[POSITIONS], points[VELOCITIES]
        self._stages = (self.x, self.v, points[Q1]), (points[X2], points[V2], points[FORCES2])

    def step(self, dt: float, forces: Forces) -> None:
        """Move on by `dt` [s] under the springs and what `forces` adds; it is called twice."""
        for stage, (x, v, force) in zip((first_stage, second_stage), self._stages, strict=True):
            force.fill(0.0)
            forces(x, v, force)
            stage(dt, *self.storage)

    def tension(self, spring: int) -> float:
        """Force in a spring [N], negative in compression."""
        return float(_tension(self.x, self.v, self.ends, self.springs, spring))

    def energy(self) -> float:
        """Kinetic and elastic energy [J]."""
        kinetic = 0.5 * float(np.sum(self.masses[:, None] * self.v**2))
        return kinetic + float(_elastic_energy(self.x, self.ends, self.springs))

    def damping_power(self) -> float:
        """Power that the dampers take out [W]."""
        return float(_damping_power(self.x, self.v, self.ends, self.springs))


@compiled
def _spring(x, v, ends, springs, index):
    """Direction from the first to the second end, length, tension, and effective stiffness and damping.

    Arrays are read before any branch: after one, numba counts references to them, which takes longer than all of this.
    """
    i, j = ends[index, 0], max(0, ends[index, 1])
    far = 0.0 if ends[index, 1] == GROUND else 1.0
    ex, ey, ez = far * x[j, 0] - x[i, 0], far * x[j, 1] - x[i, 1], far * x[j, 2] - x[i, 2]
    wx, wy, wz = far * v[j, 0] - v[i, 0], far * v[j, 1] - v[i, 1], far * v[j, 2] - v[i, 2]
    unstretched, stiffness, damping = springs[index, 0], springs[index, 1], springs[index, 2]
    compression, extension_damping = springs[index, 3], springs[index, 4]
    length = sqrt(ex * ex + ey * ey + ez * ez) + 1e-12
    ex, ey, ez = ex / length, ey / length, ez / length
    stretch = length - unstretched
    if stretch < 0.0:
        stiffness *= compression
    else:
        damping *= extension_damping
    tension = stiffness * stretch + damping * (ex * wx + ey * wy + ez * wz)
    return ex, ey, ez, length, tension, stiffness, damping


@compiled
def _pull(ends, index, fx, fy, fz, out):
    """Add a force to `out` at the first end of a spring, and take it off at the second."""
    i, j = ends[index, 0], ends[index, 1]
    out[i, 0] += fx
    out[i, 1] += fy
    out[i, 2] += fz
    if j >= 0:
        out[j, 0] -= fx
        out[j, 1] -= fy
        out[j, 2] -= fz


@compiled
def _add_spring_forces(x, v, ends, springs, out):
    for index in range(len(ends)):
        ex, ey, ez, _, tension, _, _ = _spring(x, v, ends, springs, index)
        _pull(ends, index, tension * ex, tension * ey, tension * ez, out)


@compiled
def _note_lines(x, v, ends, springs, out, lines):
    """Add the springs' forces to `out`, and fill in `lines`."""
    for index in range(len(ends)):
        ex, ey, ez, length, tension, _, _ = _spring(x, v, ends, springs, index)
        lines[index, 0], lines[index, 1], lines[index, 2] = ex, ey, ez
        lines[index, 3], lines[index, 4] = max(tension, 0.0) / length, springs[index, 1]
        lines[index, 5] = springs[index, 2] * max(1.0, springs[index, 4])
        _pull(ends, index, tension * ex, tension * ey, tension * ez, out)


@compiled
def _add_stiffness_times(ends, lines, w, factor, out):
    """Add `factor` K w to `out`; K as in the matrix."""
    for index in range(len(ends)):
        i, j = ends[index, 0], ends[index, 1]
        dx, dy, dz = -w[i, 0], -w[i, 1], -w[i, 2]
        if j >= 0:
            dx, dy, dz = dx + w[j, 0], dy + w[j, 1], dz + w[j, 2]
        ex, ey, ez = lines[index, 0], lines[index, 1], lines[index, 2]
        across = factor * lines[index, 3]
        along = (factor * lines[index, 4] - across) * (ex * dx + ey * dy + ez * dz)
        _pull(ends, index, along * ex + across * dx, along * ey + across * dy, along * ez + across * dz, out)


@compiled
def _assemble(masses, ends, starts, lines, air_damping, h, matrix):
    """Lower triangle of M - h C - h^2 K, within its envelope."""
    for point in range(len(masses)):
        for row in range(3):
            for column in range(3 * starts[point], 3 * point):
                matrix[3 * point + row, column] = 0.0
            for column in range(3):
                matrix[3 * point + row, 3 * point + column] = h * air_damping[point, row, column]
            matrix[3 * point + row, 3 * point + row] += masses[point]
    for index in range(len(ends)):
        across = h * h * lines[index, 3]
        along = h * lines[index, 5] + h * h * lines[index, 4] - across
        i, j = ends[index, 0], ends[index, 1]
        low, high = min(i, j), max(i, j)
        for row in range(3):
            for column in range(3):
                block = along * lines[index, row] * lines[index, column]
                if row == column:
                    block += across
                matrix[3 * i + row, 3 * i + column] += block
                if j >= 0:
                    matrix[3 * j + row, 3 * j + column] += block
                    matrix[3 * high + row, 3 * low + column] -= block


@compiled
def clear(forces):
    """Set `forces` (n, 3) to 0; forces[:, :] = 0.0 takes a second to compile."""
    for point in range(len(forces)):
        forces[point, 0] = forces[point, 1] = forces[point, 2] = 0.0


@compiled
def first_stage(h, points, masses, ends, springs, starts, matrix, lines, air_damping):
    """First stage; Q1 holds the external forces at (x, v), and (X2, V2) becomes the point of the second stage."""
    x, v, p1, q1 = points[POSITIONS], points[VELOCITIES], points[P1], points[Q1]
    x2, v2 = points[X2], points[V2]
    _note_lines(x, v, ends, springs, q1, lines)
    _assemble(masses, ends, starts, lines, air_damping, _GAMMA * h, matrix)
    factor(matrix, starts)
    _add_stiffness_times(ends, lines, v, _GAMMA * h, q1)
    solve(matrix, starts, q1)
    for i in range(len(masses)):
        for axis in range(3):
            p1[i, axis] = v[i, axis] + _GAMMA * h * q1[i, axis]
            x2[i, axis] = x[i, axis] + h * p1[i, axis]
            v2[i, axis] = v[i, axis] + h * q1[i, axis]


@compiled
def second_stage(h, points, masses, ends, springs, starts, matrix, lines, air_damping):
    """Second stage, and the step; FORCES2 holds the external forces at (X2, V2) and is used up."""
    x, v, p1, q1 = points[POSITIONS], points[VELOCITIES], points[P1], points[Q1]
    x2, v2, force = points[X2], points[V2], points[FORCES2]
    _add_spring_forces(x2, v2, ends, springs, force)
    for i in range(len(masses)):
        for axis in range(3):
            force[i, axis] -= 2.0 * masses[i] * q1[i, axis]
            v2[i, axis] -= 2.0 * p1[i, axis]
    _add_stiffness_times(ends, lines, v2, _GAMMA * h, force)
    solve(matrix, starts, force)
    for i in range(len(masses)):
        for axis in range(3):
            q2 = force[i, axis]
            p2 = v2[i, axis] + _GAMMA * h * q2
            x[i, axis] += h * (1.5 * p1[i, axis] + 0.5 * p2)
            v[i, axis] += h * (1.5 * q1[i, axis] + 0.5 * q2)


@compiled
def _tension(x, v, ends, springs, index):
    return _spring(x, v, ends, springs, index)[4]


@compiled
def _elastic_energy(x, ends, springs):
    energy = 0.0
    for index in range(len(ends)):
        _, _, _, length, _, stiffness, _ = _spring(x, x, ends, springs, index)
        energy += 0.5 * stiffness * (length - springs[index, 0]) ** 2
    return energy


@compiled
def _damping_power(x, v, ends, springs):
    power = 0.0
    for index in range(len(ends)):
        _, _, _, length, tension, stiffness, damping = _spring(x, v, ends, springs, index)
        if damping > 0.0:
            power += (tension - stiffness * (length - springs[index, 0])) ** 2 / damping
    return power
