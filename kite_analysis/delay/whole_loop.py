"""Gains for inner and outer loop together: the limit, the best pair, and the margins of a given pair.

The equation and the names of its terms are in characteristic_equation.py. J. H. Baayen (2012) analyses the
inner loop alone, assuming a much slower outer loop; here that is not assumed. The paper's limit is the
one at L = 0 and w = 0.
"""

import math
from typing import NamedTuple

import numpy as np

from kite_analysis.delay.characteristic_equation import ComplexArray, Gains, Loop, count_roots
from kite_analysis.delay.characteristic_roots import decay_rates, rightmost_roots

_HALVINGS = 60
_ZOOMS = 12
_LEAST_ANGLE = 1e-9  # flown in a dead time [rad]: less is lost beside rounding
_ZOOM_POINTS = 21


class Margins(NamedTuple):
    """Margins to the stability limit.

    `gain`: the factor by which P may grow; below 1, P is too high. `delay_s` [s]: by how much the dead time
    may grow; if negative, by how much it is too long; None if unstable at any delay.
    """

    gain: float
    delay_s: float | None


class Design(NamedTuple):
    """All numbers for one loop and its present gains. Gains P in 1/s; rates are real parts in 1/s.

    `limit`: greatest P at the present L, 0 where there is none; `greatest_outer_l`: from this L on there is none;
    `best` with `best_rate`: the pair whose slowest mode decays fastest; `rate`: that of the present gains.
    """

    loop: Loop
    present: Gains
    limit: float
    greatest_outer_l: float
    best: Gains
    best_rate: float
    rate: float
    margins: Margins
    roots: ComplexArray


def design(loop: Loop, present: Gains) -> Design:
    """The design for `loop`, compared with the gains `present`.

    Raises:
        ValueError: see `check`, and `rightmost_roots`.
    """
    check(loop)
    roots = rightmost_roots(loop, present)
    best, best_rate = best_gains(loop)
    return Design(loop, present, gain_limit(loop, present.outer_l), greatest_outer_l(loop), best, best_rate,
                  float(roots[0].real), margins(loop, present), roots)


def check(loop: Loop) -> None:
    """Raises ValueError, in one line, if a whole loop cannot be designed: no speed, or an impossible delay."""
    tau_s, w, lag_s = loop
    if not 0.0 < w < math.inf:
        raise ValueError(f"speed over length of {w:g} 1/s: must be positive and finite")
    if not 0.0 < tau_s < math.inf or not 0.0 <= lag_s < math.inf:
        raise ValueError(f"delay of {tau_s:g} s, lag of {lag_s:g} s: must not be negative, and finite")
    if w * tau_s < _LEAST_ANGLE:
        raise ValueError(f"speed over length of {w:g} 1/s with {tau_s:g} s of delay: the kite hardly moves in that "
                         f"time; design needs at least {_LEAST_ANGLE / tau_s:.2g} 1/s")
    if greatest_outer_l(loop) <= 0.0:
        raise ValueError(f"speed over length of {loop.speed_over_length:g} 1/s with {loop.loop_delay_s:g} s of delay: "
                         "the kite flies a quarter of a circle before it responds; no gain is stable")


def greatest_outer_l(loop: Loop) -> float:
    """The L from which on no P is stable: 1 / tan(w tau' + atan(w lag)), which is near 1 / (w (tau' + lag)).

    At a small P the loop oscillates at w, as great circles converge and diverge; the outer loop damps that if its
    response is not later than this. 0 if no L is small enough.
    """
    tau_s, w, lag_s = loop
    angle = w * tau_s + math.atan(w * lag_s)
    return 1.0 / math.tan(angle) if angle < math.pi / 2 else 0.0


def gain_limit(loop: Loop, outer_l: float) -> float:
    """Least P [1/s] at which the loop with outer gain `outer_l` no longer converges; 0 if it does with no P at all.

    On the imaginary axis, s = i o, the equation reads (o^2 - w^2) (1 + i o lag) = P exp(-i o tau') (L w + i o), so that
    atan(o / (L w)) = o tau' + atan(o lag). The left side starts steeper and is concave: there is one such o, and P
    follows from the moduli. It must lie above w. Later turns of the phase have a greater P.
    """
    tau_s, w, lag_s = loop
    if outer_l >= greatest_outer_l(loop) and w:
        return 0.0
    low, high = w, 0.5 * math.pi / tau_s
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if math.atan2(middle, outer_l * w) > middle * tau_s + math.atan(middle * lag_s):
            low = middle
        else:
            high = middle
    o = 0.5 * (low + high)
    return (o * o - w * w) * math.hypot(1.0, o * lag_s) / math.hypot(o, outer_l * w)


def best_gains(loop: Loop) -> tuple[Gains, float]:
    """The pair (P, L), neither negative, whose rightmost root lies furthest left, and its real part [1/s].

    Two gains can bring three roots together, and no pair takes them further left: as p(s) = (s^2 + w^2) (1 + s lag),
    p exp(s tau') + P s + P L w has a threefold root where its second derivative p'' + 2 tau' p' + tau'^2 p is zero, and
    the first two conditions give P and L. Without lag and for small w tau' that is, with q = 2 - sqrt(2) = 0.586,
        rate = -q / tau',  P tau' = (2 q - q^2) exp(-q) = 0.461,  L w tau' = 3 - 2 sqrt(2) = 0.172.
    Whether the threefold root is the rightmost is counted. Where it is not, or would need a negative gain (a lag or
    w tau' of the order of 1), the pair is searched for, to about 1 % of the rate.

    Raises:
        ValueError: see `check`.
    """
    check(loop)
    tau_s, w, lag_s = loop
    p = np.polynomial.Polynomial([w * w, lag_s * w * w, 1.0, lag_s]).trim()
    first, second = p.deriv(), p.deriv(2)
    for s in sorted((second + 2.0 * tau_s * first + tau_s**2 * p).roots(), key=lambda root: -root.real):
        if abs(s.imag) < 1e-9 * abs(s) and s.real < 0.0:
            rate = float(s.real)
            growth = math.exp(rate * tau_s)
            gain = -growth * float(first(rate) + tau_s * p(rate))
            product = -growth * float(p(rate)) - gain * rate
            gains = Gains(gain, product / (gain * w) if gain else -1.0)
            if min(gains) >= 0.0 and count_roots(loop, gains, rate + 1e-3 * abs(rate)) == 0:
                return gains, rate
    return _searched(loop)


def _searched(loop: Loop) -> tuple[Gains, float]:
    """The best pair by looking at a grid, and again at a finer one around its best point."""
    low, high = np.zeros(2), np.array([gain_limit(loop, 0.0), greatest_outer_l(loop)])
    floor = low
    best, rate = Gains(0.0, 0.0), 0.0
    for _ in range(_ZOOMS):
        p_axis, l_axis = (np.linspace(a, b, _ZOOM_POINTS) for a, b in zip(low, high, strict=True))
        rates = decay_rates(loop, p_axis[:, None], l_axis[None, :])
        i, j = np.unravel_index(int(np.argmin(rates)), rates.shape)
        if rates[i, j] < rate:
            best, rate = Gains(float(p_axis[i]), float(l_axis[j])), float(rates[i, j])
        half = (high - low) / 4.0
        low, high = np.maximum(floor, np.array(best) - half), np.array(best) + half
    return best, rate


def margins(loop: Loop, gains: Gains) -> Margins:
    """Margins of `gains`; both are infinite with P = 0, which steers nothing."""
    limit = gain_limit(loop, gains.outer_l)
    if gains.inner_p == 0.0:
        return Margins(math.inf, math.inf)
    return Margins(limit / gains.inner_p, _delay_margin(loop, gains))


def _delay_margin(loop: Loop, gains: Gains) -> float | None:
    """How much the delay may grow [s]: see Margins."""
    delays = _crossing_delays(loop, gains)
    if rightmost_roots(loop, gains, 1)[0].real < 0.0:
        return min((delay - loop.loop_delay_s for delay in delays if delay > loop.loop_delay_s), default=math.inf)
    without = gain_limit(loop._replace(loop_delay_s=1e-6 * loop.loop_delay_s), gains.outer_l)
    if gains.inner_p >= without:
        return None
    return min(delays) - loop.loop_delay_s


def _crossing_delays(loop: Loop, gains: Gains) -> list[float]:
    """Delays [s] at which a root crosses the imaginary axis: for each place, the first and the next after the present.

    It can cross at i o only where |o^2 - w^2| |1 + i o lag| = P |L w + i o|, and does for the delays that bring the
    phase there. Above w there is one such o, since the left side over the right grows; below w there are none, one or
    two, from a cubic in o^2.
    """
    tau_s, w, lag_s = loop
    a = gains.outer_l * w

    def excess(o: float) -> float:
        return (o - w) * (o + w) * math.hypot(1.0, o * lag_s) - gains.inner_p * math.hypot(a, o)

    low = high = w
    while excess(high) <= 0.0:
        high = 2.0 * high
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) <= 0.0 else (low, middle)
    crossings = [0.5 * (low + high)]
    x = np.polynomial.Polynomial([0.0, 1.0])
    squares = ((x - w * w) ** 2 * (1.0 + lag_s**2 * x) - gains.inner_p**2 * (x + a * a)).trim().roots()
    crossings += [math.sqrt(square.real) for square in squares
                  if abs(square.imag) <= 1e-9 * abs(square) and 0.0 < square.real < w * w]
    delays: list[float] = []
    for o in crossings:
        phase = math.atan2(o, a) - math.atan(o * lag_s) + (0.0 if o > w else math.pi)
        first = phase % math.tau
        turns = math.floor((o * tau_s - first) / math.tau) + 1
        delays += [first / o, (first + math.tau * turns) / o]
    return delays
