"""Velocities that vortex lines of unit circulation induce: the law of Biot and Savart.

Formulas of J. Katz and A. Plotkin, "Low-Speed Aerodynamics", section 10.4, in the form without trigonometry of
M. Drela, "Flight Vehicle Aerodynamics", equation 6.33. Points that lie on a line feel nothing of it.
"""

from math import pi

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_CORE_M2 = 1e-8  # square of the radius within which a vortex fades


def of_segments(points: Array, start: Array, end: Array) -> Array:
    """Velocities (p, k, 3) at `points` (p, 3) of straight vortices from `start` to `end`, each (k, 3)."""
    a = points[:, None] - start
    b = points[:, None] - end
    size_a, size_b = _sizes(a), _sizes(b)
    product = size_a * size_b
    share = (size_a + size_b) / ((product + _dots(a, b) + _CORE_M2) * (product + _CORE_M2))
    return (share / (4.0 * pi))[..., None] * np.cross(a, b)


def of_rays(points: Array, start: Array, direction: Array) -> Array:
    """Velocities (p, k, 3) at `points` (p, 3) of vortices from `start` (k, 3) to infinity along unit `direction`."""
    a = points[:, None] - start
    size = _sizes(a)
    share = 1.0 / (size * (size - a @ direction) + _CORE_M2)
    return (share / (4.0 * pi))[..., None] * np.cross(direction, a)


def _sizes(a: Array) -> Array:
    return np.sqrt(_dots(a, a))


def _dots(a: Array, b: Array) -> Array:
    return np.einsum("...i,...i->...", a, b)
