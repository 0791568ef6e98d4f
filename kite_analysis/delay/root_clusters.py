"""Roots of an analytic function from approximations to them, multiple roots included.

Eigenvalues of an m-fold root lie on a circle around it with a radius of the m-th root of rounding, about
1e-4 of the scale for a triple one; their angles depend on the processor. Newton's method does not help:
within that circle the function itself is below rounding. Well determined is the cluster as a whole: its mean
and its size. So approximations that lie close together are refined together, as the roots of the
function's Taylor polynomial at their mean; roots that the function cannot separate are returned as the mean, m times.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

ComplexArray = NDArray[np.complex128]

ROUNDING = 100.0 * float(np.finfo(float).eps)  # of a value of the function, as a share of its terms' size
_TINY = float(np.finfo(float).tiny)
_NOTHING = 1e-100  # a leading coefficient this small beside the largest has its root far away
_MORE_TERMS = 6  # of the Taylor polynomial, beyond the cluster's multiplicity
_REFINEMENTS = 3
_FURTHEST = 8.0  # steps of clustering by which a refined root may lie off its cluster's mean, for each of its members


class Expansion(NamedTuple):
    """Taylor coefficients (degree + 1,) of the function, lowest first, and the size of the terms that it adds up."""

    coefficients: ComplexArray
    size: float


class Cluster(NamedTuple):
    """Roots (m,) that were refined together, and how close to them [as the roots] the function is below rounding."""

    roots: ComplexArray
    radius: float


Expand = Callable[[complex, int], Expansion]


def clusters(values: ComplexArray, within: float) -> Iterator[ComplexArray]:
    """The groups of `values` (n,) that hang together by steps of at most `within`.

    If the values are symmetric about the real axis, so is each group, or all of it lies further than half of `within`
    from that axis and its mirror image is another group.
    """
    left = values
    while len(left):
        group = fresh = left[:1]
        left = left[1:]
        while len(fresh):
            near = (np.abs(left[:, None] - fresh[None, :]) <= within).any(axis=1)
            fresh, left = left[near], left[~near]
            group = np.append(group, fresh)
        yield group


def refined(approximations: ComplexArray, expand: Expand, within: float) -> Cluster | None:
    """The roots that the cluster `approximations` (m,) of `clusters` stands for; None where there are not m nearby.

    `expand` gives the function's Taylor polynomial at a point, in powers of (s - point) / `within`, up to a degree.
    """
    m = len(approximations)
    start = complex(approximations.mean())
    mean = start = complex(start.real) if abs(start.imag) <= 0.5 * within else start
    offsets = np.zeros(m, dtype=np.complex128)
    for _ in range(_REFINEMENTS):
        coefficients = expand(mean, m + _MORE_TERMS).coefficients
        if not np.all(np.isfinite(coefficients)) or not coefficients[m]:
            return None
        offsets = _smallest_roots(coefficients, m)
        if len(offsets) < m:
            return None
        middle = complex(offsets.mean())
        offsets, mean = offsets - middle, mean + within * middle
        if max(np.abs(offsets).max(), abs(mean - start) / within) > _FURTHEST * m:
            return None
    coefficients, size = expand(mean, m)
    radius = float((ROUNDING * size / max(abs(coefficients[m]), _TINY)) ** (1.0 / m))
    offsets = offsets * (np.abs(offsets).max() > radius)
    return Cluster(mean + within * offsets, within * radius)


def _smallest_roots(coefficients: ComplexArray, count: int) -> ComplexArray:
    """The `count` smallest roots of a polynomial, lowest coefficient first; conjugate pairs if it is real."""
    size = np.abs(coefficients)
    falling = coefficients[::-1] * (size > _NOTHING * size.max())[::-1]  # np.roots leaves leading zeros out
    roots = np.asarray(np.roots(falling if np.any(falling.imag) else falling.real), dtype=np.complex128)
    return roots[np.argsort(np.abs(roots), kind="stable")][:count]
