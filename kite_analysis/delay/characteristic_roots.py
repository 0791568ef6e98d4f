"""Roots of the whole loop's characteristic equation, none missed: found by a spectral method, then counted.

Of the loop's history, only the wanted turning rate is needed, over one dead time. It is held at Chebyshev nodes,
along which it travels, and the eigenvalues of that finite system converge to the rightmost roots of the equation (see
characteristic_equation.py) faster than any power of the number of nodes (the method of D. Breda, S. Maset and
R. Vermiglio, "Pseudospectral differencing methods for characteristic roots of delay differential equations", 2005).
Newton's method refines single roots to rounding, clusters are refined as a whole, and the argument principle verifies
all are there.
"""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kite_analysis.delay.characteristic_equation import (
    Array,
    Gains,
    Loop,
    characteristic,
    check_equation,
    count_roots,
    expansion,
    slope,
    term_size,
)
from kite_analysis.delay.root_clusters import ROUNDING, Cluster, ComplexArray, Expansion, clusters, refined

_NODES = (24, 48, 72)
_MAP_NODES = 11
_NEWTON_STEPS = 8
_FAST_PAIRS = 8
_FAST_STEPS = 60
_CLUSTER = 1e-3  # eigenvalues closer than this over tau' are refined together
_LEAST_GAP = 1e-6  # between real parts, for a count between them, as a share of these


def rightmost_roots(loop: Loop, gains: Gains, count: int = 8) -> ComplexArray:
    """The `count` rightmost roots [1/s], or one more to keep a conjugate pair together; rightmost first.

    Fewer if the others lie so far left that rounding hides them (with P near 0 they go to minus infinity), but at
    least one. A multiple root is given as often as it counts; so are roots that rounding hides from each other.

    Raises:
        ValueError: the loop has no positive delay, or a gain is negative or not finite.
        ArithmeticError: the number of roots found differs from the argument principle's count.
    """
    check_equation(loop, gains)
    best = np.zeros(0, dtype=complex)
    for values in _approximations(loop, gains):
        found = _rightmost(loop, gains, values, count)
        if len(found) > len(best):
            best = found
        if len(best) >= count:
            break
    if not len(best):
        raise ArithmeticError(f"roots of {loop} with {gains}: not as many found as counted")
    return best


def _approximations(loop: Loop, gains: Gains) -> Iterator[ComplexArray]:
    """Ever better sets of numbers among which the rightmost roots should be; the last one for very large gains."""
    for nodes in _NODES:
        yield np.linalg.eigvals(_matrices(loop, gains.inner_p, gains.outer_l, nodes)).astype(np.complex128)
    yield _fast_roots(loop, gains)


def _fast_roots(loop: Loop, gains: Gains) -> ComplexArray:
    """The roots of a loop with so large a gain that all eigenvalues drown in rounding: fast, and far to the right.

    The equation reads s tau' = log(-P (s + L w) / ((s^2 + w^2) (1 + s lag))) + 2 pi i k, for all k. Where s tau' is
    large the right side hardly depends on s, so that it can be put in for the left side again and again.
    """
    tau_s, w, lag_s = loop
    with np.errstate(all="ignore"):
        turns = 2j * np.pi * np.arange(_FAST_PAIRS)
        s = (np.log(1.0 + gains.inner_p * tau_s) + 1j * np.pi + turns) / tau_s
        for _ in range(_FAST_STEPS):
            loud = np.log(gains.inner_p) + np.log(s + gains.outer_l * w) - np.log(s + 1j * w) - np.log(s - 1j * w)
            s = (loud - np.log(1.0 + s * lag_s) + 1j * np.pi + turns) / tau_s
        s = s[np.isfinite(s) & (s.imag > 0.0)]
    return np.append(s, s.conj())


def _rightmost(loop: Loop, gains: Gains, values: ComplexArray, count: int) -> ComplexArray:
    """Those of the rightmost roots that the eigenvalues `values` stand for and that the argument principle confirms."""
    roots, radii, next_real = _refined(loop, gains, values)
    edge = _edge(np.append(roots.real, next_real), np.append(radii, 0.0), count)
    found = roots[roots.real > edge]
    confirmed = len(found) > 0 and count_roots(loop, gains, edge) == len(found)
    return found if confirmed else roots[:0]


def decay_rates(loop: Loop, inner_p: ArrayLike, outer_l: ArrayLike) -> Array:
    """Real part [1/s] of the rightmost root for each pair of gains: negative where errors decay.

    `inner_p` [1/s] and `outer_l` are broadcast against each other; the result has their common shape. For a map: right
    to about 1e-6 / tau', but not counted root by root as in `rightmost_roots`.
    """
    inner_p, outer_l = np.broadcast_arrays(np.asarray(inner_p, dtype=float), np.asarray(outer_l, dtype=float))
    values = np.linalg.eigvals(_matrices(loop, inner_p, outer_l, _MAP_NODES))
    return values.real.max(axis=-1)


def _matrices(loop: Loop, inner_p: ArrayLike, outer_l: ArrayLike, nodes: int) -> Array:
    """The finite systems for gains of shape (...): (..., n, n).

    State: cross-track error d, course error c, the lagged turning rate over P if there is a lag, and the wanted turning
    rate over P, r = L d - c, as it was at the nodes 1 to `nodes` of a dead time; node 0 is now.
        d' = -w c,  c' = w d + P r(t - tau'),  and r travels along the nodes.
    """
    tau_s, w, lag_s = loop
    inner_p, outer_l = np.asarray(inner_p, dtype=float), np.asarray(outer_l, dtype=float)
    travel = _differentiation(nodes) * (2.0 / tau_s)
    states = 3 if lag_s else 2
    matrix = np.zeros((*inner_p.shape, states + nodes, states + nodes))
    matrix[..., 0, 1] = -w
    matrix[..., 1, 0] = w
    matrix[..., 1, 2 if lag_s else -1] = inner_p
    if lag_s:
        matrix[..., 2, 2] = -1.0 / lag_s
        matrix[..., 2, -1] += 1.0 / lag_s
    matrix[..., states:, 0] = travel[1:, 0] * outer_l[..., None]
    matrix[..., states:, 1] = -travel[1:, 0]
    matrix[..., states:, states:] = travel[1:, 1:]
    return matrix


def _differentiation(nodes: int) -> Array:
    """Chebyshev's differentiation matrix on the nodes cos(k pi / nodes), from 1 to -1 (Trefethen, 2000, ch. 6)."""
    k = np.arange(nodes + 1)
    x = np.cos(np.pi * k / nodes)
    weight = np.where((k == 0) | (k == nodes), 2.0, 1.0) * (-1.0) ** k
    matrix = np.outer(weight, 1.0 / weight) / (x[:, None] - x[None, :] + np.eye(nodes + 1))
    return matrix - np.diag(matrix.sum(axis=1))


def _refined(loop: Loop, gains: Gains, values: ComplexArray) -> tuple[ComplexArray, Array, float]:
    """Those of the eigenvalues `values` that are roots, rightmost first, and the radii in which rounding hides them.

    Single ones by Newton's method, clusters by root_clusters.py. One that this carries off is no root yet, or
    never; the list ends there, and its real part comes last.
    """
    within = _CLUSTER / loop.loop_delay_s
    groups = list(clusters(values, within))
    single = np.array([group[0] for group in groups if len(group) == 1], dtype=np.complex128)
    roots, radii, good = _polished(loop, gains, single)

    def expand(centre: complex, degree: int) -> Expansion:
        return expansion(loop, gains, centre, degree, within)

    for group in groups:
        if len(group) > 1 and group.mean().imag > -0.5 * within:
            cluster = refined(group, expand, within) or Cluster(group, 0.0)
            members = cluster.roots
            if group.mean().imag > 0.5 * within:
                members = np.append(members, members.conj())
            roots = np.append(roots, members)
            radii = np.append(radii, np.full(len(members), cluster.radius))
            good = np.append(good, np.full(len(members), cluster.radius > 0.0))
    order = np.lexsort((-roots.imag, -roots.real))
    roots, radii, good = roots[order], radii[order], good[order]
    end = len(roots) if good.all() else int(np.argmin(good))
    return roots[:end], radii[:end], float(roots[end].real) if end < len(roots) else -math.inf


def _polished(loop: Loop, gains: Gains, values: ComplexArray) -> tuple[ComplexArray, Array, NDArray[np.bool_]]:
    """Newton's method from each of `values`: where it ends, the radii of rounding, and whether it stayed nearby."""
    roots = values.copy()
    with np.errstate(all="ignore"):
        for _ in range(_NEWTON_STEPS):
            step = characteristic(loop, gains, roots) / slope(loop, gains, roots)
            roots = np.where(np.isfinite(step), roots - step, roots)
        radii = ROUNDING * term_size(loop, gains, roots) / np.abs(slope(loop, gains, roots))
        good = (np.abs(roots - values) * loop.loop_delay_s < _CLUSTER) & np.isfinite(radii)
    return np.where(good, roots, values), np.where(good, radii, 0.0), good


def _edge(real: Array, radii: Array, count: int) -> float:
    """A number that parts the first `count` of the falling `real`, or a few more, from the next; fewer if need be.

    It lies in the middle of a gap that is wider than the `radii` of rounding on its sides, so that the argument
    principle has neither a root nor noise on its way.
    """
    low = np.minimum.accumulate(real - radii)[:-1]
    high = np.maximum.accumulate((real + radii)[::-1])[::-1][1:]
    gaps = np.flatnonzero(low - high > _LEAST_GAP * (np.abs(low) + np.abs(high)))
    if not len(gaps):
        return math.inf
    after = gaps[gaps >= count - 1]
    k = int(after[0] if len(after) else gaps[-1])
    return 0.5 * float(low[k] + max(high[k], low[k] - 2.0 * (1.0 + abs(low[k]))))
