"""The sampled whole loop, solved exactly: a check on the half period that represents sampling elsewhere.

A steering command holds for a period T. In the whole loop's equation (characteristic_roots.py) that is half a
period more of dead time, which is right for slow roots: it neglects (s T)^2 / 24 beside 1. Here the kite's motion
between two samples is solved exactly, so that the loop becomes a recursion with roots z = exp(s T).
"""

import math
from typing import NamedTuple

import numpy as np

from kite_analysis.delay.characteristic_equation import Array, ComplexArray, Gains

_ANGLES = 4000
_HALVINGS = 60


class SampledLoop(NamedTuple):
    """Dead time tau without sampling [s], rate [Hz], speed over line length [1/s], the actuator's time constant [s]."""

    delay_s: float
    loop_hz: float
    speed_over_length: float
    lag_s: float = 0.0


class _Period(NamedTuple):
    """From one sample to the next: x[n + 1] = step x[n] + new r[n - m] + old r[n - m - 1].

    The dead time is m periods and a part of one. x is cross-track error, course error and,
    if there is a lag, the lagged turning rate; r = P (L d - c) the wanted turning rate.
    In modal coordinates: `z` are the eigenvalues of `step`, `vectors` its eigenvectors.
    """

    z: ComplexArray
    vectors: ComplexArray
    new: ComplexArray
    old: ComplexArray
    m: int


def sampled_roots(loop: SampledLoop, gains: Gains) -> ComplexArray:
    """The roots s = log(z) / T [1/s] of the recursion, rightmost first, without z = 0; about tau / T of them."""
    period = _period(loop)
    states, past = len(period.z), period.m + 1
    wanted = np.zeros(states)
    wanted[:2] = gains.inner_p * gains.outer_l, -gains.inner_p
    new, old = ((period.vectors @ effect).real for effect in (period.new, period.old))
    matrix = np.zeros((states + past, states + past))  # state: x, then the wanted turning rates of the samples before
    matrix[:states, :states] = ((period.vectors * period.z) @ np.linalg.inv(period.vectors)).real
    matrix[states, :states] = wanted
    matrix[states + 1 :, states:-1] = np.eye(past - 1)
    matrix[:states, -1] = old
    if period.m:
        matrix[:states, -2] = new
    else:
        matrix[:states, :states] += np.outer(new, wanted)
    z = np.linalg.eigvals(matrix).astype(complex)
    s = np.log(z[np.abs(z) > 1e-9]) * loop.loop_hz
    return np.asarray(s[np.argsort(-s.real)], dtype=np.complex128)


def sampled_limit(loop: SampledLoop, outer_l: float) -> float:
    """Least P [1/s] at which the recursion with outer gain `outer_l` no longer converges; 0 if no P does.

    On the unit circle, 1 + P G(z) = 0 needs a real, negative G. A small P moves the root at exp(i w T), the kite's own
    swing, by -P times G's residue there: it must lead inwards.
    """
    period = _period(loop)
    seen = np.array([-outer_l, 1.0]) @ period.vectors[:2]

    def residues(z: ComplexArray) -> ComplexArray:
        delayed = np.power.outer(z, -period.m - 1.0)
        return seen * (np.outer(delayed * z, period.new) + np.outer(delayed, period.old))

    def answer(angle: Array) -> ComplexArray:
        z = np.exp(1j * angle)
        return (residues(z) / (z[:, None] - period.z)).sum(axis=1)

    mode = int(np.argmax(period.z.imag))
    swing = period.z[mode : mode + 1]
    if (residues(swing)[0, mode] * swing[0].conj()).real <= 0.0:
        return 0.0
    angles = np.linspace(float(np.angle(swing[0])), math.pi, max(_ANGLES, 20 * period.m))[1:]
    imaginary = answer(angles[:-1]).imag
    limits = [-1.0 / answer(angles[-1:]).real[0]]
    for k in np.flatnonzero(imaginary[:-1] * imaginary[1:] <= 0.0):
        low, high = angles[k], angles[k + 1]
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            same = answer(np.array([middle])).imag[0] * imaginary[k] > 0.0
            low, high = (middle, high) if same else (low, middle)
        limits.append(-1.0 / answer(np.array([low])).real[0])
    return float(min((limit for limit in limits if limit > 0.0), default=math.inf))


def _period(loop: SampledLoop) -> _Period:
    """The kite over a period: d' = -w c, c' = w d + v, and v the held r, or lag v' = r - v.

    Raises:
        ValueError: the speed over length or the rate is not positive, or a time is negative.
    """
    tau_s, rate_hz, w, lag_s = loop
    if not (tau_s >= 0.0 and rate_hz > 0.0 and w > 0.0 and lag_s >= 0.0 and math.isfinite(tau_s + rate_hz + w + lag_s)):
        raise ValueError(f"{loop}: rate and speed over length must be positive, times not negative, and all finite")
    motion, push = np.array([[0.0, -w], [w, 0.0]]), np.array([0.0, 1.0])
    if lag_s:
        motion = np.array([[0.0, -w, 0.0], [w, 0.0, 1.0], [0.0, 0.0, -1.0 / lag_s]])
        push = np.array([0.0, 0.0, 1.0 / lag_s])
    values, vectors = (np.asarray(part, dtype=np.complex128) for part in np.linalg.eig(motion))
    pushed = np.asarray(np.linalg.solve(vectors, push) / values, dtype=np.complex128)
    period_s = 1.0 / rate_hz
    m = int(tau_s * rate_hz + 1e-9)
    after_s = min(period_s, (m + 1) * period_s - tau_s)  # of the new command, up to the next sample
    z, grown = np.exp(values * period_s), np.expm1(values * after_s)
    return _Period(z, vectors, pushed * grown, pushed * (np.expm1(values * period_s) - grown), m)
