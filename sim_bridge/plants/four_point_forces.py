"""Forces on the four-point kite: air on its top and tips, drag of its lines, weight.

U. Fechner et al., "Dynamic model of a pumping kite power system" (2015), section 2.4, as in the MIT-licensed
KiteModels (KPS4), which lists its forces with the opposite sign. Kite frame: z from the top to the middle of the tips,
y from the right tip to the left one, x = y cross z forward. Points are those of the tether, the last of them the pod,
then nose, top, left tip, right tip. The kite's springs have the drag of lines of the bridle's diameter; the published
code gives them the tether's.
"""

from math import atan2, radians, sqrt
from typing import NamedTuple

import numpy as np

from sim_bridge.compiled import compiled
from sim_bridge.plants.four_point_settings import FourPointSettings
from sim_bridge.plants.particles import (
    FORCES2,
    POSITIONS,
    Q1,
    V2,
    VELOCITIES,
    X2,
    Points,
    clear,
    first_stage,
    second_stage,
)
from sim_bridge.plants.polars import Polars, coefficient, depower_angle
from sim_bridge.plants.tether import GRAVITY, add_tether_loads

_SLOPE_OVER = 0.02  # step of the angle of attack by which the lift's slope is taken


class Sizes(NamedTuple):
    """Numbers of the kite and its tether, as the compiled forces take them; angles in radians."""

    area_m2: float
    side_area: float  # of each tip, over the whole area
    drag_correction: float
    top_angle: float  # added to the top's angle of attack: the zero angle less depower
    tip_angle: float  # added to the tips'
    steering_angle: float  # full steering adds it to the one tip's, takes it off the other's
    line_diameter_m: float
    segments: int
    tether_diameter_m: float
    drag_coefficient: float  # of tether and lines
    lift: Points  # tables of Polars
    drag: Points

    @classmethod
    def of(cls, settings: FourPointSettings) -> "Sizes":
        """From the settings of the kite and its tether."""
        kite, frame, tether = settings.kite, settings.four_point, settings.tether
        return cls(
            kite.area_m2, kite.side_area, frame.drag_correction,
            radians(frame.alpha_zero_deg) - depower_angle(kite.depower), radians(frame.alpha_tip_deg),
            radians(frame.steering_deg), kite.bridle_diameter_m, tether.segments, tether.diameter_m,
            tether.drag_coefficient, *Polars.of(kite))

    def storage(self) -> tuple[Points, Points, Points]:
        """The same, as `_sizes` takes it."""
        return np.array(self[:-2], dtype=np.float64), self.lift, self.drag


@compiled
def _sizes(numbers, lift, drag):
    """The Sizes in their `storage`."""
    return Sizes(numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5], numbers[6], int(numbers[7]),
                 numbers[8], numbers[9], lift, drag)


@compiled
def kite_frame(x, first):
    """The unit vectors x, z, y of the kite frame, nine numbers; `first` is the nose's index."""
    top, left, right = first + 1, first + 2, first + 3
    yx, yy, yz = x[left, 0] - x[right, 0], x[left, 1] - x[right, 1], x[left, 2] - x[right, 2]
    zx = 0.5 * (x[left, 0] + x[right, 0]) - x[top, 0]
    zy = 0.5 * (x[left, 1] + x[right, 1]) - x[top, 1]
    zz = 0.5 * (x[left, 2] + x[right, 2]) - x[top, 2]
    width = sqrt(yx * yx + yy * yy + yz * yz) + 1e-12
    height = sqrt(zx * zx + zy * zy + zz * zz) + 1e-12
    yx, yy, yz, zx, zy, zz = yx / width, yy / width, yz / width, zx / height, zy / height, zz / height
    return yy * zz - yz * zy, yz * zx - yx * zz, yx * zy - yy * zx, zx, zy, zz, yx, yy, yz


@compiled
def kite_state(x, v, first, shares):
    """Position and velocity of the centre of mass, whose points have `shares` (4,) of it, and the unit vector x."""
    px = py = pz = vx = vy = vz = 0.0
    for point in range(4):
        share, index = shares[point], first + point
        px, py, pz = px + share * x[index, 0], py + share * x[index, 1], pz + share * x[index, 2]
        vx, vy, vz = vx + share * v[index, 0], vy + share * v[index, 1], vz + share * v[index, 2]
    frame = kite_frame(x, first)
    return (px, py, pz), (vx, vy, vz), (frame[0], frame[1], frame[2])


@compiled
def tips_and_top(x, first):
    """Distance of the tips from each other, and how far up from them, away from the pod, the top is [m]."""
    pod, top, left, right = first - 1, first + 1, first + 2, first + 3
    width = tip_height = top_height = 0.0
    for axis in range(3):
        middle = 0.5 * (x[left, axis] + x[right, axis])
        up = middle - x[pod, axis]
        width += (x[left, axis] - x[right, axis]) ** 2
        tip_height += up * up
        top_height += (x[top, axis] - middle) * up
    return sqrt(width), top_height / (sqrt(tip_height) + 1e-12)


@compiled
def _surface(v, point, wind, frame, normal):
    """Apparent wind at `point` (three numbers), its size across the unit vector `normal`, and the angle of attack.

    That angle lies between the kite's -x and the apparent wind without its part along the normal; it has no sign.
    """
    ax, ay, az = wind[0] - v[point, 0], wind[1] - v[point, 1], wind[2] - v[point, 2]
    along = ax * normal[0] + ay * normal[1] + az * normal[2]
    px, py, pz = ax - along * normal[0], ay - along * normal[1], az - along * normal[2]
    across = sqrt(px * px + py * py + pz * pz)
    back = px * frame[0] + py * frame[1] + pz * frame[2]
    return ax, ay, az, across, atan2(sqrt(max(0.0, across * across - back * back)), -back)


@compiled
def _add_surface_force(v, point, wind, frame, normal, lift_factor, drag_factor, added_angle, sizes, out):
    """Lift, along the apparent wind cross the normal, and drag; the factors are 0.5 rho times an area."""
    ax, ay, az, across, alpha = _surface(v, point, wind, frame, normal)
    lift = lift_factor * coefficient(sizes.lift, alpha + added_angle) * across
    drag = drag_factor * coefficient(sizes.drag, alpha + added_angle) * sqrt(ax * ax + ay * ay + az * az)
    nx, ny, nz = normal
    out[point, 0] += lift * (ay * nz - az * ny) + drag * ax
    out[point, 1] += lift * (az * nx - ax * nz) + drag * ay
    out[point, 2] += lift * (ax * ny - ay * nx) + drag * az


@compiled
def _set_surface_damping(v, point, wind, frame, normal, lift_factor, added_angle, sizes, out):
    """The lift's loss by velocity along itself, which changes the angle of attack: the largest part of the damping."""
    ax, ay, az, across, alpha = _surface(v, point, wind, frame, normal)
    alpha += added_angle
    slope = (coefficient(sizes.lift, alpha + _SLOPE_OVER) - coefficient(sizes.lift, alpha)) / _SLOPE_OVER
    damping = abs(lift_factor) * max(0.0, slope) / (across + 1e-9)
    nx, ny, nz = normal
    direction = (ay * nz - az * ny, az * nx - ax * nz, ax * ny - ay * nx)  # as long as the wind across the normal
    for row in range(3):
        for column in range(3):
            out[point, row, column] = damping * direction[row] * direction[column]


@compiled
def add_wing_forces(x, v, first, steering, density, wind, sizes, out):
    """Add lift and drag [N] of top and tips to `out`; `first` is the nose's index, `wind` (3,) the same for all."""
    frame = kite_frame(x, first)
    z, y = frame[3:6], frame[6:9]
    lift, tip_lift, turn = _lift_factors(steering, density, sizes)
    drag = (1.0 - sizes.side_area) * sizes.drag_correction
    _add_surface_force(v, first + 1, wind, frame, y, lift, drag * lift, sizes.top_angle, sizes, out)
    _add_surface_force(v, first + 2, wind, frame, z, tip_lift, drag * tip_lift, sizes.tip_angle + turn, sizes, out)
    _add_surface_force(v, first + 3, wind, frame, z, -tip_lift, drag * tip_lift, sizes.tip_angle - turn, sizes, out)


@compiled
def set_air_damping(x, v, first, steering, density, wind, sizes, out):
    """The wing's part of Arrays.air_damping."""
    frame = kite_frame(x, first)
    z, y = frame[3:6], frame[6:9]
    lift, tip_lift, turn = _lift_factors(steering, density, sizes)
    _set_surface_damping(v, first + 1, wind, frame, y, lift, sizes.top_angle, sizes, out)
    _set_surface_damping(v, first + 2, wind, frame, z, tip_lift, sizes.tip_angle + turn, sizes, out)
    _set_surface_damping(v, first + 3, wind, frame, z, tip_lift, sizes.tip_angle - turn, sizes, out)


@compiled
def _lift_factors(steering, density, sizes):
    """0.5 rho times the areas of top and tip, and the angle that steering adds to the left tip's."""
    lift = 0.5 * density * sizes.area_m2
    return lift, lift * sizes.side_area, steering * sizes.steering_angle


@compiled
def _add_line_drag(x, v, ends, first_spring, density, wind, sizes, out):
    """Drag of the kite's own springs, as lines of the bridle's diameter."""
    for index in range(first_spring, len(ends)):
        i, j = ends[index, 0], ends[index, 1]
        ex, ey, ez = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        length = sqrt(ex * ex + ey * ey + ez * ez) + 1e-12
        ex, ey, ez = ex / length, ey / length, ez / length
        wx = wind[0] - 0.5 * (v[i, 0] + v[j, 0])
        wy = wind[1] - 0.5 * (v[i, 1] + v[j, 1])
        wz = wind[2] - 0.5 * (v[i, 2] + v[j, 2])
        along = wx * ex + wy * ey + wz * ez
        wx, wy, wz = wx - along * ex, wy - along * ey, wz - along * ez
        half = 0.25 * density * sizes.drag_coefficient * sizes.line_diameter_m * length * sqrt(
            wx * wx + wy * wy + wz * wz)
        for point in (i, j):
            out[point, 0] += half * wx
            out[point, 1] += half * wy
            out[point, 2] += half * wz


@compiled
def add_forces(x, v, masses, ends, steering, density, wind, tether_wind, sizes, out):
    """Add all forces but the springs' [N] to `out` (n, 3)."""
    for point in range(len(masses)):
        out[point, 2] -= GRAVITY * masses[point]
    add_tether_loads(x, v, sizes.segments, sizes.tether_diameter_m, sizes.drag_coefficient, density, tether_wind, out)
    _add_line_drag(x, v, ends, sizes.segments, density, wind, sizes, out)
    add_wing_forces(x, v, sizes.segments, steering, density, wind, sizes, out)


@compiled
def advance(h, steps, steering, density, wind, tether_wind, numbers, lift, drag, points, masses, ends, springs,
            starts, matrix, lines, air_damping):
    """Several steps of `h` [s], as ParticleSystem.step does them.

    From `numbers` on: storage of the kite's sizes, and of its particle system.
    """
    sizes = _sizes(numbers, lift, drag)
    x, v, forces = points[POSITIONS], points[VELOCITIES], points[Q1]
    x2, v2, forces2 = points[X2], points[V2], points[FORCES2]
    for _ in range(steps):
        clear(forces)
        add_forces(x, v, masses, ends, steering, density, wind, tether_wind, sizes, forces)
        set_air_damping(x, v, sizes.segments, steering, density, wind, sizes, air_damping)
        first_stage(h, points, masses, ends, springs, starts, matrix, lines, air_damping)
        clear(forces2)
        add_forces(x2, v2, masses, ends, steering, density, wind, tether_wind, sizes, forces2)
        second_stage(h, points, masses, ends, springs, starts, matrix, lines, air_damping)
