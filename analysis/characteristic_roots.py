"""Roots of the whole loop's characteristic equation, none missed: found by a spectral method, then counted.

On a great circle and with small errors, inner and outer loop together obey (derived in docs/delay.md)

    s^2 + w^2 + P exp(-s tau') (s + L w) / (1 + s lag) = 0,

w the speed over the line length, tau' the dead time with half a period of the loop, `lag` the actuator's time constant.
The term w^2 is the sphere's: two great circles meet again. Without it (w^2 = 0, L = 0, no lag) a root at 0 and those
of J. H. Baayen (2012), s + P exp(-s tau) = 0, are left.

Of what the loop remembers, only the wanted turning rate is needed over a dead time. It is held at Chebyshev nodes,
along which it travels, and the eigenvalues of that finite system converge to the rightmost roots faster than any power
of the number of nodes (the method of D. Breda, S. Maset and R. Vermiglio, "Pseudospectral differencing methods for
characteristic roots of delay differential equations", 2005). Newton's method takes single ones to rounding, clusters
are refined as a whole, and the argument principle says whether all are there.
"""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.root_clusters import ROUNDING, Cluster, ComplexArray, Expansion, clusters, refined

Array = NDArray[np.float64]

_NODES = (24, 48, 72)
_MAP_NODES = 11
_NEWTON_STEPS = 8
_MOST_HALVINGS = 40
_CLUSTER = 1e-3  # eigenvalues closer than this over tau' are refined together
_LEAST_GAP = 1e-6  # between real parts, for a count between them, as a share of these


class Loop(NamedTuple):
    """What the gains have to cope with: tau' [s], speed over line length [1/s], the actuator's time constant [s]."""

    loop_delay_s: float
    speed_over_length: float
    lag_s: float = 0.0


class Gains(NamedTuple):
    """P [1/s] of the inner loop and L of the outer loop."""

    inner_p: float
    outer_l: float


def characteristic(loop: Loop, gains: Gains, s: ArrayLike) -> ComplexArray:
    """Value, at the complex `s` [1/s], of (s^2 + w^2) (1 + s lag) + P exp(-s tau') (s + L w); shape of `s`."""
    s = np.asarray(s, dtype=np.complex128)
    tau_s, w, lag_s = loop
    delayed = gains.inner_p * np.exp(-s * tau_s) * (s + gains.outer_l * w)
    return np.asarray((s * s + w * w) * (1.0 + s * lag_s) + delayed)


def _slope(loop: Loop, gains: Gains, s: ComplexArray) -> ComplexArray:
    """Derivative of `characteristic` by s."""
    tau_s, w, lag_s = loop
    delayed = gains.inner_p * np.exp(-s * tau_s) * (1.0 - tau_s * (s + gains.outer_l * w))
    return 2.0 * s * (1.0 + s * lag_s) + lag_s * (s * s + w * w) + delayed


def rightmost_roots(loop: Loop, gains: Gains, count: int = 8) -> ComplexArray:
    """The `count` roots [1/s] that lie furthest right, or one more where that would part a pair; rightmost first.

    Fewer where the others lie so far left that rounding hides them (with P near 0 they go to minus infinity), but at
    least one. A multiple root is given as often as it counts; so are roots that rounding hides from each other.

    Raises:
        ValueError: the loop has no positive delay, or a gain is negative or not finite.
        ArithmeticError: the roots found are not as many as the argument principle counts.
    """
    _check(loop, gains)
    best = np.zeros(0, dtype=complex)
    for nodes in _NODES:
        values = np.linalg.eigvals(_matrices(loop, gains.inner_p, gains.outer_l, nodes)).astype(np.complex128)
        found = _rightmost(loop, gains, values, count)
        if len(found) > len(best):
            best = found
        if len(best) >= count:
            break
    if not len(best):
        raise ArithmeticError(f"roots of {loop} with {gains}: not as many found as counted")
    return best


def _rightmost(loop: Loop, gains: Gains, values: ComplexArray, count: int) -> ComplexArray:
    """Those of the rightmost roots that the eigenvalues `values` stand for and that the argument principle confirms."""
    roots, radii, next_real = _refined(loop, gains, values)
    edge = _edge(np.append(roots.real, next_real), np.append(radii, 0.0), count)
    found = roots[roots.real > edge]
    confirmed = len(found) > 0 and count_roots(loop, gains, edge) == len(found)
    return found if confirmed else roots[:0]


def decay_rates(loop: Loop, inner_p: ArrayLike, outer_l: ArrayLike) -> Array:
    """Real part [1/s] of the rightmost root for each pair of gains: negative where errors die out.

    `inner_p` [1/s] and `outer_l` are broadcast against each other; the result has their common shape. For a map: right
    to about 1e-6 / tau', but not counted root by root as in `rightmost_roots`.
    """
    inner_p, outer_l = np.broadcast_arrays(np.asarray(inner_p, dtype=float), np.asarray(outer_l, dtype=float))
    values = np.linalg.eigvals(_matrices(loop, inner_p, outer_l, _MAP_NODES))
    return values.real.max(axis=-1)


def count_roots(loop: Loop, gains: Gains, right_of: float) -> int:
    """How many roots have a real part above `right_of` [1/s], by the argument principle; none may have just that one.

    All of them lie within `_reach` of 0. The phase is followed along the upper half of a rectangle around them; the
    lower half adds the same.
    """
    far = _reach(loop, gains, right_of)
    corners = np.array([far, far + 1j * far, right_of + 1j * far, right_of])
    points = min(100_000, 200 + int(far * loop.loop_delay_s / 0.2))  # exp(-s tau') turns by 0.2 rad at a time
    path = np.concatenate([np.linspace(a, b, points) for a, b in pairwise(corners)])
    phase_steps = np.zeros(1)
    for _ in range(_MOST_HALVINGS):
        values = characteristic(loop, gains, path)
        phase_steps = np.angle(values[1:] / np.where(values[:-1] == 0.0, 1e-300, values[:-1]))
        coarse = np.flatnonzero(np.abs(phase_steps) > 0.5)
        if not len(coarse):
            break
        path = np.insert(path, coarse + 1, 0.5 * (path[coarse] + path[coarse + 1]))
    return round(math.fsum(phase_steps) / math.pi)


def _reach(loop: Loop, gains: Gains, right_of: float) -> float:
    """A distance from 0 [1/s] beyond which no root lies to the right of `right_of`.

    There |s^2 + w^2| |1 + s lag| is more than P exp(-right_of tau') (|s| + L w), and stays so further out.
    """
    tau_s, w, lag_s = loop
    delayed = gains.inner_p * math.exp(-right_of * tau_s)
    far = 1.0 / tau_s + 2.0 * (abs(right_of) + w + 1.0)
    while True:
        lag = max(1.0 + min(0.0, right_of) * lag_s, far * lag_s - 1.0)
        if lag > 0.0 and (far * far - w * w) * lag > 1.1 * delayed * (far + gains.outer_l * w):
            return far
        far *= 1.5


def _matrices(loop: Loop, inner_p: ArrayLike, outer_l: ArrayLike, nodes: int) -> Array:
    """The finite systems for gains of shape (...): (..., n, n).

    State: cross-track error d, course error c, the lagged turning rate over P if there is a lag, and the wanted turning
    rate over P, r = L d - c, as it was at the nodes 1 to `nodes` of a dead time; node 0 is now.
        d' = -w c,  c' = w d + P r(t - tau'),  and r travels along the nodes.
    """
    tau_s, w, lag_s = loop
    inner_p, outer_l = np.asarray(inner_p, dtype=float), np.asarray(outer_l, dtype=float)
    travel = _differentiation(nodes) * (2.0 / tau_s)
    own = 3 if lag_s else 2
    matrix = np.zeros((*inner_p.shape, own + nodes, own + nodes))
    matrix[..., 0, 1] = -w
    matrix[..., 1, 0] = w
    matrix[..., 1, 2 if lag_s else -1] = inner_p
    if lag_s:
        matrix[..., 2, 2] = -1.0 / lag_s
        matrix[..., 2, -1] += 1.0 / lag_s
    matrix[..., own:, 0] = travel[1:, 0] * outer_l[..., None]
    matrix[..., own:, 1] = -travel[1:, 0]
    matrix[..., own:, own:] = travel[1:, 1:]
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

    Single ones by Newton's method, clusters by analysis/root_clusters.py. One that this carries off is no root yet, or
    never; the list ends there, and its real part comes last.
    """
    within = _CLUSTER / loop.loop_delay_s
    groups = list(clusters(values, within))
    single = np.array([group[0] for group in groups if len(group) == 1], dtype=np.complex128)
    roots, radii, good = _polished(loop, gains, single)

    def expand(centre: complex, degree: int) -> Expansion:
        return _expansion(loop, gains, centre, degree, within)

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
            step = characteristic(loop, gains, roots) / _slope(loop, gains, roots)
            roots = np.where(np.isfinite(step), roots - step, roots)
        radii = ROUNDING * _size(loop, gains, roots) / np.abs(_slope(loop, gains, roots))
        good = (np.abs(roots - values) * loop.loop_delay_s < _CLUSTER) & np.isfinite(radii)
    return np.where(good, roots, values), np.where(good, radii, 0.0), good


def _size(loop: Loop, gains: Gains, s: ComplexArray) -> Array:
    """The sum of the moduli of the terms of `characteristic` at `s`, of the shape of `s`."""
    tau_s, w, lag_s = loop
    delayed = gains.inner_p * np.exp(-s.real * tau_s) * (np.abs(s) + gains.outer_l * w)
    return (np.abs(s) ** 2 + w * w) * (1.0 + np.abs(s) * lag_s) + delayed


def _expansion(loop: Loop, gains: Gains, centre: complex, degree: int, scale: float) -> Expansion:
    """`characteristic` around `centre` [1/s], in powers of (s - centre) / `scale` [1/s], up to `degree`, 3 or more."""
    tau_s, w, lag_s = loop
    order = np.arange(degree + 1)
    falling = np.cumprod(np.append(1.0, -tau_s * scale / order[1:]))  # of exp(-(s - centre) tau')
    delayed = (centre + gains.outer_l * w) * falling + scale * np.append(0.0, falling[:-1])
    delayed = delayed * gains.inner_p * np.exp(-centre * tau_s)
    swing = np.array([centre**2 + w * w, 2.0 * centre * scale, scale**2], dtype=np.complex128)
    own = np.convolve(swing, [1.0 + centre * lag_s, lag_s * scale])
    delayed[: len(own)] += own[: degree + 1]
    return Expansion(delayed, float(_size(loop, gains, np.array(centre))))


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


def _check(loop: Loop, gains: Gains) -> None:
    if not 0.0 < loop.loop_delay_s < math.inf:
        raise ValueError(f"loop delay of {loop.loop_delay_s:g} s: must be longer than zero, and finite")
    if not 0.0 <= loop.speed_over_length < math.inf:
        raise ValueError(f"speed over length of {loop.speed_over_length:g} 1/s: must be zero or more, and finite")
    if not 0.0 <= loop.lag_s < math.inf:
        raise ValueError(f"lag of {loop.lag_s:g} s: must be zero or longer, and finite")
    for name, gain in zip("PL", gains, strict=True):
        if not 0.0 <= gain < math.inf:
            raise ValueError(f"gain {name} of {gain:g}: must be zero or more, and finite")
