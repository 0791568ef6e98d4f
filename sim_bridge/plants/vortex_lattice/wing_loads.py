"""Circulation and forces of a vortex lattice whose equations have been solved: see wing_flow."""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim_bridge.compiled import compiled

Array = NDArray[np.float64]


class Solved(NamedTuple):
    """A lattice of n panels with k vortices, the n bound ones and then the legs' pieces, by rows; m strips.

    All is linear in the 12 numbers z = (motion, steering times motion), motion = (onset flow, rotation).
    """

    strength: Array  # (n, 12): circulation of each panel is this times z
    lift: Array  # (k, 3, 12): V cross l at each vortex is this times z
    middle: Array  # (k, 3): where its force acts
    strip_chord: Array  # (m,)
    strip_area: Array  # (m,)
    strip_centre: Array  # (m, 3)


@compiled
def find_loads(solved, motion, steering, density, profile_drag, greatest_lift, circulation, section_lift, forces,
               loads):
    """Fill in all that WingFlow keeps of a call."""
    _find_circulation(solved, motion, steering, greatest_lift, circulation, section_lift)
    _find_forces(solved, motion, steering, density, circulation, forces)
    _add_up(solved, motion, density, profile_drag, forces, loads)


@compiled
def _find_circulation(solved, motion, steering, greatest_lift, circulation, section_lift):
    """Fill in the `circulation` (n,) [m^2/s] of the panels, and the coefficients `section_lift` (m,) of the strips.

    Where a strip's coefficient would exceed `greatest_lift`, its circulation is scaled down to it.
    """
    strips = len(solved.strip_chord)
    for panel in range(len(circulation)):
        value = 0.0
        for i in range(6):
            value += (solved.strength[panel, i] + steering * solved.strength[panel, i + 6]) * motion[i]
        circulation[panel] = value
    for strip in range(strips):
        total = 0.0
        for panel in range(strip, len(circulation), strips):
            total += circulation[panel]
        vx, vy, vz = _onset(motion, solved.strip_centre, strip)
        speed = sqrt(vx * vx + vy * vy + vz * vz) + 1e-9
        section_lift[strip] = 2.0 * total / (speed * solved.strip_chord[strip])
        share = greatest_lift / (abs(section_lift[strip]) + 1e-9)
        if share < 1.0:
            section_lift[strip] *= share
            for panel in range(strip, len(circulation), strips):
                circulation[panel] *= share


@compiled
def _find_forces(solved, motion, steering, density, circulation, forces):
    """Fill in the `forces` (k, 3) [N] on all vortices, from the panels' `circulation` (n,): rho Gamma V cross l."""
    panels, strips = len(circulation), len(solved.strip_chord)
    for panel in range(panels):
        _force(solved, motion, steering, density * circulation[panel], panel, forces)
    vortex = panels
    for row in range(panels // strips):
        for edge in range(strips + 1):
            strength = 0.0  # what the horseshoes of this row and those before leave on the leg
            for upstream in range(row + 1):
                if edge > 0:
                    strength += circulation[upstream * strips + edge - 1]
                if edge < strips:
                    strength -= circulation[upstream * strips + edge]
            _force(solved, motion, steering, density * strength, vortex, forces)
            vortex += 1


@compiled
def _add_up(solved, motion, density, profile_drag, forces, loads):
    """Fill in force and moment about the origin, `loads` (6,), of the vortices' `forces` and the strips' drag."""
    loads[:] = 0.0
    for vortex in range(len(forces)):
        _add(solved.middle, vortex, forces[vortex, 0], forces[vortex, 1], forces[vortex, 2], loads)
    for strip in range(len(solved.strip_chord)):
        vx, vy, vz = _onset(motion, solved.strip_centre, strip)
        factor = 0.5 * density * profile_drag * solved.strip_area[strip] * sqrt(vx * vx + vy * vy + vz * vz)
        _add(solved.strip_centre, strip, factor * vx, factor * vy, factor * vz, loads)


@compiled
def _onset(motion, points, index):
    """V - omega cross r at a point."""
    x, y, z = points[index, 0], points[index, 1], points[index, 2]
    return (motion[0] - motion[4] * z + motion[5] * y, motion[1] - motion[5] * x + motion[3] * z,
            motion[2] - motion[3] * y + motion[4] * x)


@compiled
def _force(solved, motion, steering, strength, vortex, forces):
    for axis in range(3):
        value = 0.0
        for i in range(6):
            value += (solved.lift[vortex, axis, i] + steering * solved.lift[vortex, axis, i + 6]) * motion[i]
        forces[vortex, axis] = strength * value


@compiled
def _add(points, index, fx, fy, fz, loads):
    x, y, z = points[index, 0], points[index, 1], points[index, 2]
    loads[0] += fx
    loads[1] += fy
    loads[2] += fz
    loads[3] += y * fz - z * fy
    loads[4] += z * fx - x * fz
    loads[5] += x * fy - y * fx
