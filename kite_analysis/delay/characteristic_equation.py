"""The whole loop's characteristic equation: value, slope, expansion, and the number of roots in a half-plane.

On a great circle and with small errors, inner and outer loop together obey (derived in docs/delay.md)

    s^2 + w^2 + P exp(-s tau') (s + L w) / (1 + s lag) = 0,

w the speed over the line length, tau' the dead time with half a period of the loop, `lag` the actuator's time constant.
The term w^2 comes from the sphere: great circles converge. Without it (w^2 = 0, L = 0, no lag) a root at 0 and those
of J. H. Baayen (2012), s + P exp(-s tau) = 0, are left.
"""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kite_analysis.delay.root_clusters import ComplexArray, Expansion

Array = NDArray[np.float64]

_MOST_HALVINGS = 40
_MOST_GAIN = 1e30  # far beyond this the terms overflow


class Loop(NamedTuple):
    """The loop that the gains are for: tau' [s], speed over line length [1/s], the actuator's time constant [s]."""

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


def slope(loop: Loop, gains: Gains, s: ComplexArray) -> ComplexArray:
    """Derivative of `characteristic` by s."""
    tau_s, w, lag_s = loop
    delayed = gains.inner_p * np.exp(-s * tau_s) * (1.0 - tau_s * (s + gains.outer_l * w))
    return 2.0 * s * (1.0 + s * lag_s) + lag_s * (s * s + w * w) + delayed


def term_size(loop: Loop, gains: Gains, s: ComplexArray) -> Array:
    """The sum of the moduli of the terms of `characteristic` at `s`, of the shape of `s`."""
    tau_s, w, lag_s = loop
    delayed = gains.inner_p * np.exp(-s.real * tau_s) * (np.abs(s) + gains.outer_l * w)
    return (np.abs(s) ** 2 + w * w) * (1.0 + np.abs(s) * lag_s) + delayed


def expansion(loop: Loop, gains: Gains, centre: complex, degree: int, scale: float) -> Expansion:
    """`characteristic` around `centre` [1/s], in powers of (s - centre) / `scale` [1/s], up to `degree`, 3 or more."""
    tau_s, w, lag_s = loop
    order = np.arange(degree + 1)
    falling = np.cumprod(np.append(1.0, -tau_s * scale / order[1:]))  # of exp(-(s - centre) tau')
    delayed = (centre + gains.outer_l * w) * falling + scale * np.append(0.0, falling[:-1])
    delayed = delayed * gains.inner_p * np.exp(-centre * tau_s)
    swing = np.array([centre**2 + w * w, 2.0 * centre * scale, scale**2], dtype=np.complex128)
    undelayed = np.convolve(swing, [1.0 + centre * lag_s, lag_s * scale])
    delayed[: len(undelayed)] += undelayed[: degree + 1]
    return Expansion(delayed, float(term_size(loop, gains, np.array(centre))))


def count_roots(loop: Loop, gains: Gains, right_of: float) -> int:
    """How many roots have a real part above `right_of` [1/s], by the argument principle; none may have just that one.

    All of them lie within `_reach` of 0. The phase is tracked along the upper half of a rectangle around them; the
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


def check_equation(loop: Loop, gains: Gains) -> None:
    """Raises ValueError, in one line, if the equation has no delay or an invalid number."""
    if not 0.0 < loop.loop_delay_s < math.inf:
        raise ValueError(f"loop delay of {loop.loop_delay_s:g} s: must be longer than zero, and finite")
    if not 0.0 <= loop.speed_over_length < math.inf:
        raise ValueError(f"speed over length of {loop.speed_over_length:g} 1/s: must be zero or more, and finite")
    if not 0.0 <= loop.lag_s < math.inf:
        raise ValueError(f"lag of {loop.lag_s:g} s: must be zero or longer, and finite")
    for name, gain in zip("PL", gains, strict=True):
        if not 0.0 <= gain <= _MOST_GAIN:
            raise ValueError(f"gain {name} of {gain:g}: must be zero or more, and at most {_MOST_GAIN:g}")
