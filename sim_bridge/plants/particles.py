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


class Arrays(NamedTuple):
    """What the two stages of a step work on, beside the state and the forces."""

    masses: Points  # (n,)
    ends: NDArray[np.int64]  # (springs, 2)
    springs: Points  # (springs, 5), the rest of Spring
    starts: NDArray[np.int64]  # (n,), the matrix's envelope
    matrix: Points
    p1: Points
    q1: Points
    x2: Points  # where the second stage takes its forces
    v2: Points
    lines: Points  # (springs, 6), of the first stage: direction, tension over length, stiffness, damping
    air_damping: Points  # (n, 3, 3), what the outer forces lose by each point's velocity, symmetric; 0 is good, too


class ParticleSystem:
    """State: positions `x` and velocities `v`, (n, 3) each, in the wind frame.

    `step` suits forces in plain Python; compiled ones call `first_stage` and `second_stage` with `arrays`.
    """

    def __init__(self, positions: Points, velocities: Points, masses: Points, springs: Sequence[Spring]):
        self.x = np.array(positions, dtype=np.float64)
        self.v = np.array(velocities, dtype=np.float64)
        self.masses = np.array(masses, dtype=np.float64)
        count = len(self.masses)
        self.ends = np.array([spring[:2] for spring in springs], dtype=np.int64)
        self.springs = np.array([spring[2:] for spring in springs], dtype=np.float64)
        p1, q1, x2, v2 = (np.zeros((count, 3)) for _ in range(4))
        self.arrays = Arrays(
            self.masses, self.ends, self.springs, _envelope(count, self.ends), np.zeros((3 * count, 3 * count)),
            p1, q1, x2, v2, np.zeros((len(springs), 6)), np.zeros((count, 3, 3)))
        self._force = np.zeros((count, 3))

    def step(self, dt: float, forces: Forces) -> None:
        """Move on by `dt` [s] under the springs and what `forces` adds; it is called twice."""
        force = self._force
        force.fill(0.0)
        forces(self.x, self.v, force)
        first_stage(self.x, self.v, force, dt, self.arrays)
        force.fill(0.0)
        forces(self.arrays.x2, self.arrays.v2, force)
        second_stage(self.x, self.v, force, dt, self.arrays)

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


def _envelope(count: int, ends: NDArray[np.int64]) -> NDArray[np.int64]:
    """For each point the first one that it is coupled to: left of that the matrix is empty."""
    starts = np.arange(count)
    for first, second in ends:
        low, high = min(first, second), max(first, second)
        if low >= 0:
            starts[high] = min(starts[high], low)
    return starts


@compiled
def _spring(x, v, ends, springs, index):
    """Direction from the first to the second end, length, tension, and effective stiffness and damping."""
    i, j = ends[index, 0], ends[index, 1]
    ex, ey, ez = -x[i, 0], -x[i, 1], -x[i, 2]
    wx, wy, wz = -v[i, 0], -v[i, 1], -v[i, 2]
    if j >= 0:
        ex, ey, ez = ex + x[j, 0], ey + x[j, 1], ez + x[j, 2]
        wx, wy, wz = wx + v[j, 0], wy + v[j, 1], wz + v[j, 2]
    length = sqrt(ex * ex + ey * ey + ez * ez) + 1e-12
    ex, ey, ez = ex / length, ey / length, ez / length
    stretch = length - springs[index, 0]
    stiffness = springs[index, 1]
    damping = springs[index, 2]
    if stretch < 0.0:
        stiffness *= springs[index, 3]
    else:
        damping *= springs[index, 4]
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
        _pull(ends, index, tension * ex, tension * ey, tension * ez, out)
        lines[index, 0], lines[index, 1], lines[index, 2] = ex, ey, ez
        lines[index, 3], lines[index, 4] = max(tension, 0.0) / length, springs[index, 1]
        lines[index, 5] = springs[index, 2] * max(1.0, springs[index, 4])


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
def _assemble(masses, ends, lines, air_damping, h, matrix):
    """Lower triangle of M - h C - h^2 K."""
    matrix[:, :] = 0.0
    for point in range(len(masses)):
        for row in range(3):
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
def _factor(matrix, starts):
    """Cholesky factor in the lower triangle of `matrix`, within its envelope."""
    for row in range(len(matrix)):
        first = 3 * starts[row // 3]
        for column in range(first, row + 1):
            value = matrix[row, column]
            for k in range(max(first, 3 * starts[column // 3]), column):
                value -= matrix[row, k] * matrix[column, k]
            matrix[row, column] = sqrt(value) if row == column else value / matrix[column, column]


@compiled
def _solve(matrix, starts, vector):
    """Solve in place with the factor from `_factor`; `vector` is (n, 3)."""
    size = len(matrix)
    for row in range(size):
        value = vector[row // 3, row % 3]
        for k in range(3 * starts[row // 3], row):
            value -= matrix[row, k] * vector[k // 3, k % 3]
        vector[row // 3, row % 3] = value / matrix[row, row]
    for row in range(size - 1, -1, -1):
        value = vector[row // 3, row % 3] / matrix[row, row]
        vector[row // 3, row % 3] = value
        for k in range(3 * starts[row // 3], row):
            vector[k // 3, k % 3] -= matrix[row, k] * value


@compiled
def first_stage(x, v, force, h, arrays):
    """First stage; `force` holds the external forces at (x, v), (x2, v2) becomes the point of the second stage."""
    masses, ends, springs, starts, matrix, p1, q1, x2, v2, lines, air_damping = arrays
    for i in range(len(masses)):  # not q1[:, :] = force: that takes seconds to compile
        for axis in range(3):
            q1[i, axis] = force[i, axis]
    _note_lines(x, v, ends, springs, q1, lines)
    _assemble(masses, ends, lines, air_damping, _GAMMA * h, matrix)
    _factor(matrix, starts)
    _add_stiffness_times(ends, lines, v, _GAMMA * h, q1)
    _solve(matrix, starts, q1)
    for i in range(len(masses)):
        for axis in range(3):
            p1[i, axis] = v[i, axis] + _GAMMA * h * q1[i, axis]
            x2[i, axis] = x[i, axis] + h * p1[i, axis]
            v2[i, axis] = v[i, axis] + h * q1[i, axis]


@compiled
def second_stage(x, v, force, h, arrays):
    """Second stage, and the step; `force` holds the external forces at (x2, v2) and is used up."""
    masses, ends, springs, starts, matrix, p1, q1, x2, v2, lines, _ = arrays
    _add_spring_forces(x2, v2, ends, springs, force)
    for i in range(len(masses)):
        for axis in range(3):
            force[i, axis] -= 2.0 * masses[i] * q1[i, axis]
            v2[i, axis] -= 2.0 * p1[i, axis]
    _add_stiffness_times(ends, lines, v2, _GAMMA * h, force)
    _solve(matrix, starts, force)
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
