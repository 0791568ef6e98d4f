"""Whether an eight can be flown, as the parameters' texts say it: none of the firmware's code, on a fine grid."""

import math
from functools import cache

import numpy as np

from kite_analysis.figure_eight import TargetEight

DISTANCE_M = 100.0  # that the samples measure
HIGHEST_DEG = 85.0
NAMES = ("EIGHT_AZIMUTH", "EIGHT_ELEVATION", "EIGHT_HALF_W", "EIGHT_HALF_H", "EIGHT_DIRECTION", "EIGHT_LEAST_EL",
         "WINDOW_ANGLE", "TURN_K", "STEER_MAX")
GRID = np.linspace(0.0, 2.0 * np.pi, 721)


def can_be_flown(parameters: dict[str, float]) -> bool | None:
    """True, False, or None where it is a close call."""
    return _judge(tuple(parameters[name] for name in NAMES))


@cache
def _judge(values: tuple[float, ...]) -> bool | None:
    value: dict[str, float] = dict(zip(NAMES, values, strict=True))
    if value["EIGHT_ELEVATION"] - value["EIGHT_HALF_H"] < value["EIGHT_LEAST_EL"]:
        return False
    if value["EIGHT_ELEVATION"] + value["EIGHT_HALF_H"] > HIGHEST_DEG:
        return False
    shape = TargetEight.from_parameters(lambda name: value[name])
    position = shape.position(GRID)
    furthest = math.degrees(math.acos(position[:, 0].min()))
    first, second = shape.derivatives(GRID)
    curvature = np.abs(np.sum(position * np.cross(first, second), axis=1)) / np.linalg.norm(first, axis=1) ** 3
    tightest = curvature.max() / (DISTANCE_M * value["TURN_K"] * value["STEER_MAX"])
    if furthest < value["WINDOW_ANGLE"] - 1.0 and tightest < 0.9:
        return True
    return False if furthest > value["WINDOW_ANGLE"] + 1.0 or tightest > 1.1 else None
