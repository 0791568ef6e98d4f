"""The loop as flown: under the plain law, with rate feed-forward, or with prediction.

In the whole loop's terms (characteristic_roots.py: d the cross-track error, c the course's against the
target's direction, w speed over line length) the kite's turning rate is what was decided a dead time ago,

    r = P (L d - c) + F (omega + L d'),    d' = -w c,    c' = w d + r - omega,

where omega is the rate at which the target's own direction turns and F the fraction of the target's rate in the
feed-forward. The kite aims at the target from its own position, so the target's rate contains L d', which acts
like F L w added to P. With a = (-w, s) E the response of (d, c) to r, E = exp(-s tau'), the modes are exp(s t) with

    s^2 + w^2 + P (a_c - L a_d) + F L w a_c = 0,

which for F = 0 is the whole loop's equation. Prediction over h has the same form: with the matrix A of d' and c' above,
the state used by the loops is a = (I + exp(A h) (exp(-s tau) - exp(-s h))) (-w, s). Where h is tau the delay is gone,
and any P and L are stable up to what sampling takes; an error of h brings exp(-s tau) - exp(-s h) back in, and with it
a limit near P = 1 / |tau - h|.

A target that turns drives the loop: d (s) = w omega (1 - F E) / (left side above). An eight's omega is its geodesic
curvature times w, so that the cross-track error that it leaves follows from its harmonics. That says what following an
eight takes: P as large as the margins allow, several times the gain that settles fastest. The paper's optimum is for a
target at rest.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kite_analysis.delay.characteristic_roots import Array, ComplexArray, Gains
from kite_analysis.figure_eight import TargetEight

_FREQUENCIES = 6000
_LINE = 4096  # points on a curve
_HARMONICS = 256


class FlownLoop(NamedTuple):
    """Dead time tau without sampling [s], loop rate [Hz], speed over line length w [1/s], and the law.

    `feed_forward` is the share F of the target's rate, smoothed over `filter_s` [s]; `predicted_s` is h [s], 0 where
    nothing is predicted.
    """

    delay_s: float
    loop_hz: float
    speed_over_length: float
    feed_forward: float = 0.0
    filter_s: float = 0.0
    predicted_s: float = 0.0


def flown_limit(loop: FlownLoop, outer_l: float) -> float:
    """Lowest P [1/s] at which the loop with outer gain `outer_l` no longer converges; 0 if none does.

    On the imaginary axis P must be real: P = -M / N, with N what P multiplies and M the rest. The prediction acts half
    a period further on, which deals with the hold, and is stable up to P = 1 / T by itself.
    """
    w = loop.speed_over_length
    highest = math.pi * loop.loop_hz
    s = _imaginary(np.geomspace(1.0005 * w, highest, _FREQUENCIES))
    by_gain, rest = _terms(loop, outer_l, s)
    swing = _imaginary(np.array([w]))
    at_swing = [term[0] for term in _terms(loop, outer_l, swing)]
    drives = at_swing[1] if loop.feed_forward else at_swing[0]
    if outer_l and (drives / swing[0]).real <= 0.0:
        return 0.0
    gain = -rest / by_gain
    crossing = np.flatnonzero(gain.imag[:-1] * gain.imag[1:] <= 0.0)
    share = gain.imag[crossing] / (gain.imag[crossing] - gain.imag[crossing + 1])
    found = gain.real[crossing] + share * (gain.real[crossing + 1] - gain.real[crossing])
    sampled = loop.loop_hz if loop.predicted_s else math.inf
    return float(min([sampled, *found[found > 0.0]]))


def following_error(loop: FlownLoop, gains: Gains, eight: TargetEight) -> float:
    """Cross-track error, RMS [rad], that following `eight` with `gains` leaves, where the loop is stable.

    For small errors: for large ones atan(L d) saturates, so does steering, and gusts come on top.
    """
    rate, period_s = turning_of(eight, loop.speed_over_length)
    harmonics = np.fft.rfft(rate)[: _HARMONICS + 1] / len(rate)
    s = _imaginary(2.0 * math.pi * np.arange(len(harmonics)) / period_s)
    by_gain, rest = _terms(loop, gains.outer_l, s)
    late_s = loop.delay_s - loop.predicted_s + (0.0 if loop.predicted_s else 0.5 / loop.loop_hz)
    fed = loop.feed_forward * np.exp(-s * late_s) / (1.0 + s * _filter(loop))
    error = np.abs(loop.speed_over_length * harmonics * (1.0 - fed) / (rest + gains.inner_p * by_gain)) ** 2
    return math.sqrt(float(error[0] + 2.0 * np.sum(error[1:])))


def turning_of(eight: TargetEight, speed_over_length: float) -> tuple[Array, float]:
    """The rate [rad/s] at which the eight's direction turns on the sphere, (n,) at even times, and its period [s]."""
    s = np.linspace(0.0, 2.0 * math.pi, _LINE + 1)
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(eight.position(s), axis=0), axis=1))])
    even = np.interp(np.linspace(0.0, way[-1], _LINE, endpoint=False), way, s)
    along, bend = eight.derivatives(even)
    curvature = np.sum(eight.position(even) * np.cross(along, bend), axis=1) / np.linalg.norm(along, axis=1) ** 3
    return curvature * speed_over_length, float(way[-1] / speed_over_length)


def _terms(loop: FlownLoop, outer_l: float, s: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """What P multiplies, and the rest, of the left side of the loop's equation at `s` (n,)."""
    w, h = loop.speed_over_length, loop.predicted_s
    if h:
        again = np.exp(-s * loop.delay_s) - np.exp(-s * h)
        cosine, sine = math.cos(w * h), math.sin(w * h)
        a_d = -w + again * (-w * cosine - s * sine)
        a_c = s + again * (-w * sine + s * cosine)
    else:
        late = np.exp(-s * (loop.delay_s + 0.5 / loop.loop_hz))
        a_d, a_c = -w * late, s * late
    fed = loop.feed_forward * outer_l * w * a_c / (1.0 + s * _filter(loop))
    return a_c - outer_l * a_d, s * s + w * w + fed


def _imaginary(frequency: NDArray[Any]) -> ComplexArray:
    return np.asarray(1j * frequency, dtype=np.complex128)


def _filter(loop: FlownLoop) -> float:
    """The time constant of the target's rate [s]: it is a smoothed difference, but exact where it is predicted."""
    return 0.0 if loop.predicted_s else loop.filter_s
