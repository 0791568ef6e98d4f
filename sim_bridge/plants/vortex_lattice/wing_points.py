"""The wing as four point masses, and what they share: pose, motion, and forces that act on the wing as one.

Four equal masses at the corners of a tetrahedron whose edges nose-tail and left-right lie along principal axes have
the mass, centre of mass and inertia of any body with one plane of symmetry: with second moments S of a body of mass m
the corners are at sqrt(2 S / m) on the axes of the edges, and at sqrt(S / m) on the third.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from sim_bridge.compiled import compiled
from sim_bridge.plants.particles import Spring

Array = NDArray[np.float64]
NOSE, TAIL, LEFT, RIGHT = range(4)


def four_points(points: Array, masses: Array) -> tuple[Array, Array, Array]:
    """Corners (4, 3) about the centre, principal axes as columns (3, 3), and centre (3,) of `masses` at `points`.

    The axes are as near to those of the coordinates as they can be; the body is symmetric to y = 0.
    """
    mass = np.add.reduce(masses)
    centre = masses @ points / mass
    centre[1] = 0.0
    offset = points - centre
    second = (masses[:, None] * offset).T @ offset / mass
    angle = 0.5 * np.arctan2(2.0 * second[0, 2], second[0, 0] - second[2, 2])
    axes = np.array([[np.cos(angle), 0.0, -np.sin(angle)], [0.0, 1.0, 0.0], [np.sin(angle), 0.0, np.cos(angle)]])
    a, b, c = np.sqrt(np.diag(axes.T @ second @ axes) * np.array([2.0, 2.0, 1.0]))
    corners = np.array([[a, 0.0, c], [-a, 0.0, c], [0.0, b, -c], [0.0, -b, -c]])
    return corners @ axes.T, axes, centre


def frame_springs(positions: Array, hold: int, stiffness: float, damping: float) -> list[Spring]:
    """Springs between the points of `positions` (n, 3) from `hold` on, as long as they are apart."""
    return [Spring(i, j, float(np.linalg.norm(positions[i] - positions[j])), stiffness, damping)
            for i in range(hold, len(positions)) for j in range(hold, i)]


@compiled
def find_pose(x, v, mass, axes, wind, frame, pose, motion):
    """Fill in how the wing lies and moves, from its points `x`, `v` (4, 3) of `mass` [kg] each, wind frame.

    `frame` (3, 3) takes the body axes as rows. `pose` (4, 3) takes the centre, its velocity, and the inverse of the
    inertia: its diagonal, and its (xy, xz, yz). `motion` (6,) takes the onset flow, `wind` less the centre's velocity,
    and the rotation that has the points' angular momentum, both in body axes.
    """
    for axis in range(3):
        pose[0, axis] = 0.25 * (x[0, axis] + x[1, axis] + x[2, axis] + x[3, axis])
        pose[1, axis] = 0.25 * (v[0, axis] + v[1, axis] + v[2, axis] + v[3, axis])
    _find_frame(x, axes, frame)
    xx, yy, zz, xy, xz, yz, hx, hy, hz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for point in range(4):
        rx, ry, rz = x[point, 0] - pose[0, 0], x[point, 1] - pose[0, 1], x[point, 2] - pose[0, 2]
        wx, wy, wz = v[point, 0] - pose[1, 0], v[point, 1] - pose[1, 1], v[point, 2] - pose[1, 2]
        xx += mass * (ry * ry + rz * rz)
        yy += mass * (rx * rx + rz * rz)
        zz += mass * (rx * rx + ry * ry)
        xy -= mass * rx * ry
        xz -= mass * rx * rz
        yz -= mass * ry * rz
        hx += mass * (ry * wz - rz * wy)
        hy += mass * (rz * wx - rx * wz)
        hz += mass * (rx * wy - ry * wx)
    a, b, c = yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy
    d, e, f = xz * yz - xy * zz, xy * yz - xz * yy, xy * xz - yz * xx
    size = xx * a + xy * d + xz * e + 1e-300
    pose[2, 0], pose[2, 1], pose[2, 2] = a / size, b / size, c / size
    pose[3, 0], pose[3, 1], pose[3, 2] = d / size, e / size, f / size
    rx, ry, rz = _times(pose, hx, hy, hz)
    ux, uy, uz = wind[0] - pose[1, 0], wind[1] - pose[1, 1], wind[2] - pose[1, 2]
    for axis in range(3):
        motion[axis] = frame[axis, 0] * ux + frame[axis, 1] * uy + frame[axis, 2] * uz
        motion[axis + 3] = frame[axis, 0] * rx + frame[axis, 1] * ry + frame[axis, 2] * rz


@compiled
def share_out(x, mass, frame, pose, loads, out):
    """Add `loads` (6,), force and moment about the centre in body axes, to the forces `out` (4, 3) on the points.

    Each point gets its mass times the acceleration that it would have on a rigid wing: force and moment are kept
    exactly, the sum of squares is the least, and no spring is strained.
    """
    fx, fy, fz = _to_wind_frame(frame, loads[0], loads[1], loads[2])
    mx, my, mz = _to_wind_frame(frame, loads[3], loads[4], loads[5])
    ax, ay, az = _times(pose, mx, my, mz)
    for point in range(4):
        rx, ry, rz = x[point, 0] - pose[0, 0], x[point, 1] - pose[0, 1], x[point, 2] - pose[0, 2]
        out[point, 0] += 0.25 * fx + mass * (ay * rz - az * ry)
        out[point, 1] += 0.25 * fy + mass * (az * rx - ax * rz)
        out[point, 2] += 0.25 * fz + mass * (ax * ry - ay * rx)


@compiled
def add_bridle_drag(v, wind, factor, out):
    """Add the bridle's drag to the forces `out` (5, 3), on the bridle point and the wing's, that move with `v` (5, 3).

    It is `factor`, half the density times coefficient and area, times the squared apparent wind: half of it at the
    bridle point, the other half shared by the wing's.
    """
    for point in range(5):
        wx, wy, wz = wind[0] - v[point, 0], wind[1] - v[point, 1], wind[2] - v[point, 2]
        share = (0.5 if point == 0 else 0.125) * factor * sqrt(wx * wx + wy * wy + wz * wz)
        out[point, 0] += share * wx
        out[point, 1] += share * wy
        out[point, 2] += share * wz


@compiled
def _find_frame(x, axes, frame):
    """Axes along nose-tail, left-right and across both, turned by the principal `axes`."""
    fx, fy, fz = x[0, 0] - x[1, 0], x[0, 1] - x[1, 1], x[0, 2] - x[1, 2]
    size = sqrt(fx * fx + fy * fy + fz * fz) + 1e-12
    fx, fy, fz = fx / size, fy / size, fz / size
    lx, ly, lz = x[2, 0] - x[3, 0], x[2, 1] - x[3, 1], x[2, 2] - x[3, 2]
    ux, uy, uz = fy * lz - fz * ly, fz * lx - fx * lz, fx * ly - fy * lx
    size = sqrt(ux * ux + uy * uy + uz * uz) + 1e-12
    ux, uy, uz = ux / size, uy / size, uz / size
    lx, ly, lz = uy * fz - uz * fy, uz * fx - ux * fz, ux * fy - uy * fx
    for row in range(3):
        a, b, c = axes[row, 0], axes[row, 1], axes[row, 2]
        frame[row, 0] = a * fx + b * lx + c * ux
        frame[row, 1] = a * fy + b * ly + c * uy
        frame[row, 2] = a * fz + b * lz + c * uz


@compiled
def _to_wind_frame(frame, x, y, z):
    return (frame[0, 0] * x + frame[1, 0] * y + frame[2, 0] * z, frame[0, 1] * x + frame[1, 1] * y + frame[2, 1] * z,
            frame[0, 2] * x + frame[1, 2] * y + frame[2, 2] * z)


@compiled
def _times(pose, x, y, z):
    """The inverse inertia times a vector."""
    return (pose[2, 0] * x + pose[3, 0] * y + pose[3, 1] * z, pose[3, 0] * x + pose[2, 1] * y + pose[3, 2] * z,
            pose[3, 1] * x + pose[3, 2] * y + pose[2, 2] * z)
