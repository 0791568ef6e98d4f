"""Lift and drag coefficients over all angles of attack, and the change of that angle by depowering.

The polars are interpolating cubic splines with not-a-knot ends (what scipy's UnivariateSpline with k=3, s=0 gives),
tabulated once, so that compiled code reads them:

    polars = Polars.of(KiteSettings())
    c_l = coefficient(polars.lift, alpha)       # alpha in rad, any; both here and in compiled functions
    c_d = coefficient(polars.drag, alpha)
"""

from collections.abc import Sequence
from math import acos, hypot, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim_bridge.compiled import compiled
from sim_bridge.errors import ScenarioError
from sim_bridge.plants.kite_settings import KiteSettings

Table = NDArray[np.float64]

# The control pod's winch and bridle, of the MIT-licensed KitePodModels and its default settings.
_ZERO = 0.236  # depower at which the angle is 0
_TURNS = 10.0 * 11.0 / 3.0 * (3918.8 - 230.8) / 4096.0  # of the drum, for the whole range of depower
_DRUM_M, _TAPE_M = 0.069, 0.0006  # diameter of the drum, thickness of the tape on it
_POWER_TO_STEERING_M = 1.3  # from the power lines to the steering lines on the kite
_BRIDLE_M = 4.9 + 0.5 * 2.23  # from the pod to the kite


class Polars(NamedTuple):
    """Tables for `coefficient`, (n, 5) each: where a piece starts [deg], and its coefficients, constant first."""

    lift: Table
    drag: Table

    @classmethod
    def of(cls, kite: KiteSettings) -> "Polars":
        """From the lists of a kite's settings.

        Raises:
            ScenarioError: angles and coefficients do not match.
        """
        return cls(_table("lift", kite.lift_angles_deg, kite.lift_coefficients),
                   _table("drag", kite.drag_angles_deg, kite.drag_coefficients))


@compiled
def coefficient(table, alpha):
    """Value of a polar at the angle of attack `alpha` [rad], which is taken round to -180 to 180 deg."""
    angle = alpha * 180.0 / pi
    angle -= 360.0 * np.floor((angle + 180.0) / 360.0)
    piece = len(table) - 1
    while piece > 0 and angle < table[piece, 0]:
        piece -= 1
    t = angle - table[piece, 0]
    return table[piece, 1] + t * (table[piece, 2] + t * (table[piece, 3] + t * table[piece, 4]))


def depower_angle(depower: float) -> float:
    """Angle [rad] that the relative `depower` (0 to 1) takes off the angle of attack.

    The depower tape is let out from a drum whose diameter shrinks by the tape's thickness with every turn; pulleys
    halve that. Pod, power point and steering point of the kite make a triangle with two sides fixed.
    """
    length, diameter, turns = 0.0, _DRUM_M, (depower - _ZERO) * _TURNS
    while turns > 0.0:
        length += pi * diameter
        diameter -= _TAPE_M
        turns -= 1.0
    length += pi * turns * (diameter - _TAPE_M * turns)  # back to the broken turn
    a, b, c = _POWER_TO_STEERING_M, _BRIDLE_M + 0.5 * length, hypot(_POWER_TO_STEERING_M, _BRIDLE_M)
    return 0.5 * pi - acos((a * a + b * b - c * c) / (2.0 * a * b))


def _table(kind: str, at: Sequence[float], coefficients: Sequence[float]) -> Table:
    angles_key, values_key = f"kite.{kind}_angles_deg", f"kite.{kind}_coefficients"
    angles, values = np.array(at), np.array(coefficients)
    if len(angles) != len(values):
        raise ScenarioError(f"{angles_key} has {len(angles)} numbers, {values_key} {len(values)}: they must have "
                            "equal lengths")
    if len(angles) < 4 or angles[0] != -180.0 or angles[-1] != 180.0 or (np.diff(angles) <= 0.0).any():
        raise ScenarioError(f"{angles_key} takes 4 or more angles, increasing, from -180 to 180")
    return _spline(angles, values)


def _spline(x: Table, y: Table) -> Table:
    """Pieces of the not-a-knot cubic spline, by its second derivatives m at the knots."""
    h, slope = np.diff(x), np.diff(y) / np.diff(x)
    matrix, right = np.zeros((len(x), len(x))), np.zeros(len(x))
    for i in range(1, len(x) - 1):
        matrix[i, i - 1 : i + 2] = h[i - 1], 2.0 * (h[i - 1] + h[i]), h[i]
        right[i] = 6.0 * (slope[i] - slope[i - 1])
    matrix[0, :3] = h[1], -h[0] - h[1], h[0]  # the third derivative goes on over the second knot,
    matrix[-1, -3:] = h[-1], -h[-2] - h[-1], h[-2]  # and over the last but one
    m = np.linalg.solve(matrix, right)
    first = slope - h * (2.0 * m[:-1] + m[1:]) / 6.0
    return np.array([x[:-1], y[:-1], first, 0.5 * m[:-1], np.diff(m) / (6.0 * h)], dtype=np.float64).T.copy()
