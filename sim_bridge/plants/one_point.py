"""A kite that is one point on a segmented tether: lift, drag, a side force by steering.

The one-point model of U. Fechner et al., "Dynamic model of a pumping kite power system" (2015), section 2, with the
numbers of the MIT-licensed KiteModels (KPS3). The nose points into the apparent wind; steering pushes the kite
sideways, so that its velocity turns, and with it the apparent wind: the turning-rate law is not assumed, it
out.
"""

from math import asin, ceil, sqrt
from typing import NamedTuple

import numpy as np

from sim_bridge.compiled import compiled
from sim_bridge.errors import ScenarioError
from sim_bridge.plants.kite_settings import OnePointSettings
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
from sim_bridge.plants.tether import GRAVITY, Tether, add_tether_loads, lower_density
from sim_bridge.plants.tethered_kite import TetheredKite, check_start_height, flies_on, start_air, tangent_part
from sim_bridge.plants.truth import Vector
from sim_bridge.wind.air import Air
from sim_bridge.wind.wind_settings import WindSettings

_DAMPING_STEPS = 1.0  # the air damps nothing by more than exp(-1) a step: 2 is the limit of stability
_MOST_STEPS = 1000  # a state that asks for more than these is lost
_STIFF_STEPS = 40.0  # greatest h^2 k / m at which the steps are of second order; see particles
_START_SPEEDS = np.geomspace(0.02, 50.0, 80)  # tried, over the wind speed


class _Sizes(NamedTuple):
    """Numbers of the kite and its tether, as the compiled forces take them."""

    area_m2: float
    depower_rad: float
    drag_factor: float
    steering_drag: float
    side_force: float  # coefficient over the projected area, at full steering
    gravity_correction_m_s: float
    bridle_area_m2: float
    tether_diameter_m: float
    tether_drag_coefficient: float
    lift: Points  # tables of Polars
    drag: Points

    @classmethod
    def of(cls, settings: OnePointSettings) -> "_Sizes":
        kite, tether = settings.kite, settings.tether
        return cls(
            kite.area_m2, depower_angle(kite.depower), kite.bridle_drag, kite.steering_drag,
            kite.side_area * kite.steering_force, kite.gravity_correction_m_s,
            kite.bridle_length_m * kite.bridle_diameter_m, tether.diameter_m, tether.drag_coefficient,
            *Polars.of(kite))

    def storage(self) -> tuple[Points, Points, Points]:
        """The same, as `_sizes` takes it."""
        return np.array(self[:-2]), self.lift, self.drag


class OnePointKite(TetheredKite):
    """The last point of the tether is kite and control pod in one.

    Steps are `step_s` long, but no longer than the tether's stiffness and aerodynamic damping allow: 5
    ms on a 40 m tether, where half of that changes the position in steered flight by 5e-4 rad in 20 s.

    Raises:
        ScenarioError: it cannot fly there, or its sizes do not match.
    """

    def __init__(self, settings: OnePointSettings, wind: WindSettings, position: Vector, direction: Vector):
        super().__init__(Tether.of(settings.tether, settings.line_length_m), wind, settings.step_s)
        self.sizes = _Sizes.of(settings)
        self._storage = self.sizes.storage()
        masses = self.tether.masses()
        masses[-1] *= 2.0  # as published, a whole segment
        masses[-1] += settings.kite.mass_kg + settings.kite.pod_mass_kg
        gamma = np.array(position)
        check_start_height("one-point", settings.line_length_m * float(gamma[2]))
        points = self.tether.straight(self.tether.length_m * gamma)
        self.build(points, np.zeros_like(points), masses, self.tether.springs(), start_air(wind))
        self._damping = self._greatest_damping()
        tether = self.tether
        node_kg, stiffness = tether.segment_m * tether.mass_kg_m, tether.stiffness_n / tether.segment_m
        self._longest_s = min(self.step_s, sqrt(_STIFF_STEPS * node_kg / stiffness))
        self._set_off(gamma, tangent_part(gamma, np.array(direction)))

    def forces(self, x: Points, v: Points, out: Points) -> None:
        """See TetheredKite."""
        _add_forces(x, v, self.system.masses, self.steering, self.density, self.wind, self.tether_wind, self.sizes,
                    out)

    def step(self, dt: float, steering: float, air: Air) -> None:
        """Fly on by `dt` [s]; see Plant."""
        if self.trouble:
            return
        self.steering = steering
        self.feel(air)
        if not _advance(dt, self._longest_s, self._damping, steering, self.density, self.wind, self.tether_wind,
                        *self._storage, *self.system.storage):
            self._look_for_trouble()

    def state(self) -> tuple[Vector, Vector, Vector]:
        """See TetheredKite; the nose points into the apparent wind."""
        x, y, z = self.system.x[-1].tolist()
        vx, vy, vz = self.system.v[-1].tolist()
        wx, wy, wz = self.wind
        return (x, y, z), (vx, vy, vz), (vx - wx, vy - wy, vz - wz)

    def height(self) -> float:
        """See TetheredKite."""
        return float(self.system.x[-1, 2])

    def lift_and_drag(self) -> tuple[float, float]:
        """Size of the kite's lift and drag [N], negative lift pulling inwards."""
        last = np.diff(self.system.x, axis=0, prepend=0.0)[-1]
        apparent = self.apparent_wind()
        airspeed = sqrt(float(apparent @ apparent))
        lift, drag = _lift_and_drag(self.sizes, float(apparent @ last) / sqrt(float(last @ last)), airspeed,
                                    self.steering, self.density)
        return float(lift), float(drag)

    def _greatest_damping(self) -> float:
        """How fast the air damps the kite or the tether at most, over density and airspeed [m^2/kg]."""
        angles = np.radians(np.arange(-180.0, 181.0))
        slopes = np.diff([coefficient(self.sizes.lift, angle) for angle in angles]) / np.radians(1.0)
        kite = max(float(np.max(np.abs(slopes))), self.sizes.side_force) * 0.5 * self.sizes.area_m2
        tether = self.tether.drag_coefficient * self.tether.diameter_m / self.tether.mass_kg_m
        return max(kite / float(self.system.masses[-1]), tether)

    def _set_off(self, gamma: Points, course: Points) -> None:
        """Let the kite at `gamma` fly along `course` at the speed at which nothing speeds it up or brakes it."""
        system, share = self.system, np.linspace(0.0, 1.0, self.tether.segments + 1)[1:]
        force = np.zeros_like(system.x)

        def push(speed: float) -> float:
            """Force along the course, of all points as seen at the kite."""
            system.v[:] = speed * share[:, None] * course
            force.fill(0.0)
            self.forces(system.x, system.v, force)
            return float(share @ (force @ course))

        wind = float(np.linalg.norm(self.wind))
        speeds = wind * _START_SPEEDS
        driven = [i for i, speed in enumerate(speeds) if push(speed) > 0.0]
        where = f"plant.kind = one-point: in {wind:.1f} m/s of wind the kite cannot fly at the start"
        if not driven or driven[-1] + 1 == len(speeds):
            raise ScenarioError(f"{where}: no force drives it along its course there")
        low, high = float(speeds[driven[-1]]), float(speeds[driven[-1] + 1])
        for _ in range(50):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if push(middle) > 0.0 else (low, middle)
        push(low)
        pull = float(force[-1] @ gamma) + float(system.masses[-1]) * low * low / self.tether.length_m
        if pull <= 0.0:
            raise ScenarioError(f"{where}: its tether would be slack: {-pull:.0f} N of lift are missing")
        stretch = 1.0 + pull / self.tether.stiffness_n
        system.x *= stretch
        system.v *= stretch


@compiled
def _sizes(numbers, lift, drag):
    """The _Sizes in their `storage`."""
    return _Sizes(numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5], numbers[6], numbers[7],
                  numbers[8], lift, drag)


@compiled
def _lift_and_drag(sizes, outward, airspeed, steering, density):
    """Lift and drag [N]; `outward` is the apparent wind along the last segment, away from the ground."""
    pressure = 0.5 * density * airspeed * airspeed * sizes.area_m2
    alpha = asin(min(1.0, max(-1.0, outward / (airspeed + 1e-12)))) - sizes.depower_rad
    drag = coefficient(sizes.drag, alpha) * sizes.drag_factor * (1.0 + sizes.steering_drag * abs(steering))
    return pressure * coefficient(sizes.lift, alpha), pressure * drag


@compiled
def _add_kite_forces(x, v, steering, density, wind, tether_wind, sizes, out):
    """Aerodynamic forces on kite and bridle."""
    last = len(x) - 1
    px, py, pz = x[last, 0], x[last, 1], x[last, 2]
    ex, ey, ez = px, py, pz
    ux, uy, uz = v[last, 0], v[last, 1], v[last, 2]
    mx, my, mz = 0.5 * ux, 0.5 * uy, 0.5 * uz
    if last > 0:
        ex, ey, ez = px - x[last - 1, 0], py - x[last - 1, 1], pz - x[last - 1, 2]
        mx, my, mz = mx + 0.5 * v[last - 1, 0], my + 0.5 * v[last - 1, 1], mz + 0.5 * v[last - 1, 2]
    length = sqrt(ex * ex + ey * ey + ez * ez) + 1e-12
    ex, ey, ez = ex / length, ey / length, ez / length
    ax, ay, az = wind[0] - ux, wind[1] - uy, wind[2] - uz
    airspeed = sqrt(ax * ax + ay * ay + az * az)
    lift, drag = _lift_and_drag(sizes, ax * ex + ay * ey + az * ez, airspeed, steering, density)
    ax, ay, az = ax / (airspeed + 1e-12), ay / (airspeed + 1e-12), az / (airspeed + 1e-12)
    # s = gamma x nose, across the kite: where the wind blows along the tether there is no across, and no lift.
    sx, sy, sz = ay * pz - az * py, az * px - ax * pz, ax * py - ay * px
    size = sqrt(sx * sx + sy * sy + sz * sz) + 1e-9
    sx, sy, sz = sx / size, sy / size, sz / size
    side = 0.5 * density * airspeed * sizes.area_m2 * sizes.side_force * (
        airspeed * steering + sizes.gravity_correction_m_s * sz)  # sz = -sin(psi) cos(elevation)
    out[last, 0] += drag * ax + side * sx + lift * (sy * az - sz * ay)
    out[last, 1] += drag * ay + side * sy + lift * (sz * ax - sx * az)
    out[last, 2] += drag * az + side * sz + lift * (sx * ay - sy * ax)
    bx, by, bz = tether_wind[0] - mx, tether_wind[1] - my, tether_wind[2] - mz
    along = bx * ex + by * ey + bz * ez
    bx, by, bz = bx - along * ex, by - along * ey, bz - along * ez
    local = lower_density(density, 0.5 * length * ez)
    rate = 0.5 * local * sizes.tether_drag_coefficient * sqrt(bx * bx + by * by + bz * bz)
    bridle = rate * sizes.bridle_area_m2
    out[last, 0] += bridle * bx
    out[last, 1] += bridle * by
    out[last, 2] += bridle * bz
    if last > 0:  # as published, half of that on the point below, in the place of half of the last segment's drag
        below = 0.5 * bridle - 0.5 * rate * length * sizes.tether_diameter_m
        out[last - 1, 0] += below * bx
        out[last - 1, 1] += below * by
        out[last - 1, 2] += below * bz


@compiled
def _add_forces(x, v, masses, steering, density, wind, tether_wind, sizes, out):
    """All forces but the springs'."""
    for i in range(len(x)):
        out[i, 2] -= GRAVITY * masses[i]
    add_tether_loads(x, v, len(x), sizes.tether_diameter_m, sizes.tether_drag_coefficient, density, tether_wind, out)
    _add_kite_forces(x, v, steering, density, wind, tether_wind, sizes, out)


@compiled
def _advance(dt, longest, damping, steering, density, wind, tether_wind, numbers, lift, drag, points, masses, ends,
             springs, starts, matrix, lines, air_damping):
    """Steps as ParticleSystem's, none longer than `longest` [s] or than the air's damping bears.

    Returns whether the kite flies on. From `numbers` on: storage of the kite's sizes, and of its particle system.
    """
    sizes = _sizes(numbers, lift, drag)
    x, v, forces = points[POSITIONS], points[VELOCITIES], points[Q1]
    x2, v2, forces2 = points[X2], points[V2], points[FORCES2]
    last = len(x) - 1
    ax, ay, az = wind[0] - v[last, 0], wind[1] - v[last, 1], wind[2] - v[last, 2]
    rate = damping * density * sqrt(ax * ax + ay * ay + az * az) / _DAMPING_STEPS
    steps = max(1, ceil(dt / longest - 1e-6), min(_MOST_STEPS, ceil(dt * rate)))
    h = dt / steps
    for _ in range(steps):
        clear(forces)
        _add_forces(x, v, masses, steering, density, wind, tether_wind, sizes, forces)
        first_stage(h, points, masses, ends, springs, starts, matrix, lines, air_damping)
        clear(forces2)
        _add_forces(x2, v2, masses, steering, density, wind, tether_wind, sizes, forces2)
        second_stage(h, points, masses, ends, springs, starts, matrix, lines, air_damping)
    return flies_on(x, x[last, 2])
