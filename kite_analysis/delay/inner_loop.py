"""How the delay limits the inner loop's gain.

With the turning-rate law cancelled, the turning-angle error obeys de/dt (t) = -P e(t - tau), whose characteristic
roots s solve s + P exp(-s tau) = 0. The results are those of J. H. Baayen, "Trajectory tracking control of kites
with system delay" (2012), sections "A delay differential equation" and "Trajectory tracking control with delay".
`tau` is the dead time of links and actuator; `loop_delay` adds the effect of sampling.
"""

import math

import numpy as np


def stability_limit(tau_s: float) -> float:
    """Lowest gain P, in 1/s, at which the loop with dead time `tau_s` [s] no longer converges: pi / (2 tau).

    Baayen (2012), Lemma 3.2 and Proposition 4.1.

    Raises:
        ValueError: `tau_s` is not a positive, finite time.
    """
    _check_delay(tau_s)
    return math.pi / (2.0 * tau_s)


def optimal_gain(tau_s: float) -> float:
    """Gain P, in 1/s, with the fastest worst-case convergence for dead time `tau_s` [s]: 1 / (e tau).

    Baayen (2012), Lemma 3.3 and Proposition 4.1.

    Raises:
        ValueError: `tau_s` is not a positive, finite time.
    """
    _check_delay(tau_s)
    return 1.0 / (math.e * tau_s)


def loop_delay(tau_s: float, loop_hz: float) -> float:
    """Dead time tau' = tau + T/2 [s] of a loop that holds its output over the period T = 1 / `loop_hz`.

    A steering command stays on for a period, so that it acts half a period late on average. `tau_s` may be 0.

    Raises:
        ValueError: `tau_s` is negative or not finite, or `loop_hz` is not a positive, finite rate.
    """
    if not 0.0 <= tau_s < math.inf:
        raise ValueError(f"delay of {tau_s:g} s: must be zero or longer, and finite")
    if not 0.0 < loop_hz < math.inf:
        raise ValueError(f"loop rate of {loop_hz:g} Hz: must be positive and finite")
    return tau_s + 0.5 / loop_hz


def lambert_w_real_part(a: np.ndarray, branch: int) -> np.ndarray:
    """Real part of branch `branch` of the Lambert W function at the real numbers `a`, of the same shape.

    W_k(a) are the roots sigma of sigma exp(sigma) = a: the characteristic roots of dx/ds (s) = a x(s - 1), where
    time is counted in dead times and a = -P tau. No branch has a greater real part than branch 0 (Baayen (2012),
    Lemma 3.1, from Shinozaki and Mori, 2006).
    """
    from scipy.special import lambertw  # noqa: PLC0415  (an extra, and slow to load)

    a = np.asarray(a, dtype=float)
    real = np.real(lambertw(a, branch))
    if branch in (0, -1):  # where these two meet, scipy gives NaN
        real = np.where(np.isclose(a, -1.0 / math.e, rtol=1e-15), -1.0, real)
    return real


def decay_rate(gain: float, tau_s: float) -> float:
    """Real part, in 1/s, of the rightmost root of s + P exp(-s tau) = 0: negative if errors decay.

    The error shrinks like exp(decay_rate * t) in the worst case, with `gain` P [1/s] and `tau_s` [s]. The root is
    W_0(-P tau) / tau; it lies furthest left, at -1 / tau, for the optimal gain (Baayen (2012), Lemma 3.3).

    Raises:
        ValueError: `tau_s` is not a positive, finite time.
    """
    _check_delay(tau_s)
    return float(lambert_w_real_part(np.array(-gain * tau_s), 0)) / tau_s


def _check_delay(tau_s: float) -> None:
    if not 0.0 < tau_s < math.inf:
        raise ValueError(f"delay of {tau_s:g} s: must be longer than zero, and finite")
