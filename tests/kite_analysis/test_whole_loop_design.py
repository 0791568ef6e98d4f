"""The whole loop's design against Lambert's W, closed forms, its own equation, and the loop solved sample by sample."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.special import lambertw

from kite_analysis.delay.characteristic_equation import Gains, Loop, characteristic, count_roots
from kite_analysis.delay.characteristic_roots import decay_rates, rightmost_roots
from kite_analysis.delay.inner_loop import stability_limit
from kite_analysis.delay.sampled_loop import SampledLoop, sampled_limit, sampled_roots
from kite_analysis.delay.whole_loop import best_gains, design, gain_limit, greatest_outer_l, margins

SMALL_KITE = Loop(0.21, 0.45)
V3 = Loop(0.51, 0.06)
delays = st.floats(0.01, 1.0)
speeds = st.floats(0.01, 1.0)
lags = st.one_of(st.just(0.0), st.floats(0.01, 1.0))
shares = st.floats(0.02, 1.5)


def rate(loop: Loop, gains: Gains) -> float:
    return float(rightmost_roots(loop, gains, 1)[0].real)


@given(delays, st.floats(0.3, 1.7))
def test_without_an_outer_loop_and_a_sphere_the_roots_are_lambert_w(tau_s, product):
    """Beside them stands the 0 of a cross-track error that nobody looks at."""
    assume(abs(product - 1 / math.e) > 1e-6)  # a double root is known to half the digits only
    roots = rightmost_roots(Loop(tau_s, 0.0), Gains(product / tau_s, 0.0), 5)
    expected = np.array([0.0, *(lambertw(-product, branch) for branch in (0, -1, 1, -2))]) / tau_s
    distances = np.abs(roots[:5, None] - expected[None, :]) * tau_s
    assert distances.min(axis=0).max() < 1e-8 and distances.min(axis=1).max() < 1e-8


@pytest.mark.parametrize("right_of", [1.0, -1.0, -10.0, -16.0, -20.0, -25.0])
def test_the_argument_principle_counts_as_many_as_lambert_w_has(right_of):
    tau_s, p = 0.21, 9.0
    known = [0.0, *(lambertw(-p * tau_s, branch).real / tau_s for branch in range(-60, 60))]
    expected = len([real for real in known if real > right_of])
    assert count_roots(Loop(tau_s, 0.0), Gains(p, 0.0), right_of) == expected
    assert right_of > 0.0 or expected > 2


@given(delays, speeds, lags, shares, shares)
@settings(deadline=None, max_examples=150)
def test_the_roots_solve_the_equation_and_none_is_missed(tau_s, w, lag_s, p_share, l_share):
    """The count is the argument principle's; the map, which does not count, finds the same first root."""
    loop = Loop(tau_s, w, lag_s)
    gains = Gains(p_share * stability_limit(tau_s), l_share * greatest_outer_l(loop))
    roots = rightmost_roots(loop, gains)
    scale = 1.0 + np.abs(roots) ** 2 * np.abs(1.0 + roots * lag_s)
    assert np.all(np.abs(characteristic(loop, gains, roots)) < 1e-6 * scale)
    edge = roots[-1].real - 1e-4 * (1.0 + abs(roots[-1].real))
    assert count_roots(loop, gains, edge) >= len(roots)
    assert count_roots(loop, gains, roots[0].real + 1e-4 * (1.0 + abs(roots[0].real))) == 0
    assert decay_rates(loop, *gains) == pytest.approx(roots[0].real, abs=1e-3 / tau_s)


def test_roots_that_lie_together_are_counted_together():
    (gains, together) = best_gains(SMALL_KITE)
    assert count_roots(SMALL_KITE, gains, together - 0.1) == 3
    assert rightmost_roots(SMALL_KITE, gains, 3)[:3] == pytest.approx(np.full(3, together), abs=1e-3)


@pytest.mark.parametrize(("loop", "outer_l", "plane", "sphere"), [
    (SMALL_KITE, 5.0, 5.287, 5.254), (Loop(0.41, 0.45), 5.0, 0.537, 0.457), (V3, 4.0, 2.909, 2.908)])
def test_limits_of_known_kites(loop, outer_l, plane, sphere):
    """By hand: o from tan(o tau') = o / (L w), then P. In the plane o^2 / hypot(o, L w); on the sphere o^2 - w^2."""
    limit = gain_limit(loop, outer_l)
    assert limit == pytest.approx(sphere, rel=1e-3)
    tau_s, w, _ = loop
    o = next(root.imag for root in rightmost_roots(loop, Gains(limit, outer_l), 2))
    assert math.tan(o * tau_s) == pytest.approx(o / (outer_l * w), rel=1e-6)
    assert o**2 / math.hypot(o, outer_l * w) == pytest.approx(plane, rel=1e-3)


def own_best_pair_comes_back(loop: Loop) -> None:
    """`design`, told the pair that it proposes, finds its roots, the rate that it promised, and room to either side."""
    gains, best = best_gains(loop)
    told = design(loop, gains)
    assert told.rate == pytest.approx(best, rel=1e-4) and len(told.roots) >= 3
    assert told.margins.gain > 1.0 and told.margins.delay_s is not None and told.margins.delay_s > 0.0


@pytest.mark.parametrize("seed", range(2))
def test_a_design_is_answered_for_its_own_best_pair(seed):
    """At full precision, where three roots are one: whether and how rounding parts them is the processor's."""
    for tau_s, w in np.random.default_rng(seed).uniform((0.02, 0.01), (1.0, 1.0), (10, 2)):
        own_best_pair_comes_back(Loop(tau_s, w))
    for tau_s, angle in np.random.default_rng(seed).uniform((0.02, 1e-3), (1.0, 0.3), (60, 2)):
        own_best_pair_comes_back(Loop(tau_s, angle / tau_s))  # all with three roots in one


@given(delays, st.floats(1e-3, 0.3), st.floats(-16.0, -2.0), st.floats(0.0, math.tau))
@settings(deadline=None)
def test_roots_are_right_however_near_to_one_another(tau_s, angle, decades, towards):
    """From the best pair away by less than rounding, up to a hundredth: three roots part by the cube root of it."""
    loop = Loop(tau_s, angle / tau_s)
    best, together = best_gains(loop)
    off = 0.5 * 10.0**decades
    gains = Gains(best.inner_p * (1.0 + off * math.cos(towards)), best.outer_l * (1.0 + off * math.sin(towards)))
    roots = rightmost_roots(loop, gains, 3)[:3]
    assert np.abs(roots - together).max() < 4.0 * off ** (1.0 / 3.0) / tau_s + 1e-4 / tau_s
    assert roots.sum().imag == 0.0  # in conjugate pairs, to the last bit
    assert count_roots(loop, gains, roots[0].real + 2e-4 / tau_s) == 0


GAINS = st.one_of(st.sampled_from([0.0, 1e-300, 1.0, 50.0, 1e30]), st.floats(0.0, 50.0),
                  st.floats(-12.0, 15.0).map(lambda power: 10.0**power))


@given(st.one_of(delays, st.floats(1e-6, 3.0)), st.one_of(speeds, st.floats(1e-6, 10.0)),
       st.one_of(lags, st.floats(1e-9, 10.0)), GAINS, GAINS)
@settings(deadline=None, max_examples=150)
def test_every_pair_of_gains_is_answered(tau_s, w, lag_s, inner_p, outer_l):
    """A rate and margins that agree, from no gain at all to what only a slip of the finger gives."""
    loop, gains = Loop(tau_s, w, lag_s), Gains(inner_p, outer_l)
    assume(w * tau_s > 1e-8 and greatest_outer_l(loop) > 0.05)
    limit, (gain, delay_s) = gain_limit(loop, outer_l), margins(loop, gains)
    assume(not inner_p or abs(gain - 1.0) > 1e-3)
    first = rightmost_roots(loop, gains, 1)[0].real
    assert np.isfinite(first) and gain == (limit / inner_p if inner_p else math.inf)
    if inner_p > 1e-6 * w and abs(outer_l / greatest_outer_l(loop) - 1.0) > 1e-3:  # else the roots lie on the axis
        assert (first < 0.0) == (gain > 1.0)
        assert delay_s is None or (delay_s > 0.0) == (first < 0.0)


def test_the_papers_optimum_can_be_unstable():
    assert rate(Loop(0.41, 0.45), Gains(1.0 / (math.e * 0.4), 5.0)) > 0.0


@given(delays, speeds, lags, st.floats(0.0, 1.3))
@settings(deadline=None)
def test_errors_die_out_below_the_limit_and_grow_above(tau_s, w, lag_s, l_share):
    loop = Loop(tau_s, w, lag_s)
    outer_l = l_share * greatest_outer_l(loop)
    assume(greatest_outer_l(loop) > 0.05 and abs(l_share - 1.0) > 0.01)
    limit = gain_limit(loop, outer_l)
    assert (limit > 0.0) == (l_share < 1.0)
    if limit:
        assert max(rate(loop, Gains(share * limit, outer_l)) for share in (0.02, 0.3, 0.7, 0.99)) < 0.0
        assert min(rate(loop, Gains(share * limit, outer_l)) for share in (1.01, 1.5, 3.0)) > 0.0
    else:
        assert min(rate(loop, Gains(p / tau_s, outer_l)) for p in (0.001, 0.1, 0.5, 1.0)) > 0.0


@given(delays, speeds, lags, st.floats(0.05, 2.0), st.floats(0.05, 0.95))
@settings(deadline=None)
def test_margins_lead_to_the_edge_of_stability(tau_s, w, lag_s, p_share, l_share):
    loop = Loop(tau_s, w, lag_s)
    assume(greatest_outer_l(loop) > 0.05 and abs(p_share - 1.0) > 0.01)
    outer_l = l_share * greatest_outer_l(loop)
    gains = Gains(p_share * gain_limit(loop, outer_l), outer_l)
    gain, delay_s = margins(loop, gains)
    assert gain == pytest.approx(1.0 / p_share)
    assert delay_s is None or math.isinf(delay_s) or (delay_s > 0.0) == (p_share < 1.0)
    if delay_s is None:
        assert rate(loop._replace(loop_delay_s=1e-4 * tau_s), gains) > 0.0
    elif math.isfinite(delay_s):
        edge_s = tau_s + delay_s
        assert rate(loop._replace(loop_delay_s=0.995 * edge_s), gains) < 0.0
        assert rate(loop._replace(loop_delay_s=1.005 * edge_s), gains) > 0.0


@given(delays, st.floats(0.01, 0.3))
def test_the_best_pair_is_near_its_closed_form(tau_s, angle):
    """For small w tau': rate -0.586 / tau', P 0.461 / tau', L 0.172 / (w tau'); the sphere takes off w tau' squared."""
    gains, best = best_gains(Loop(tau_s, angle / tau_s))
    q = 2.0 - math.sqrt(2.0 - angle**2)
    assert best * tau_s == pytest.approx(-q, rel=1e-9)
    assert gains.inner_p * tau_s == pytest.approx(0.4612, abs=0.7 * angle**2 + 1e-4)
    assert gains.outer_l * angle == pytest.approx(3.0 - 2.0 * math.sqrt(2.0), abs=2.0 * angle**2 + 1e-4)


@pytest.mark.parametrize("loop", [SMALL_KITE, V3, Loop(0.01, 0.06), Loop(0.21, 0.45, 0.1), Loop(0.21, 0.45, 0.5),
                                  Loop(0.6, 1.0)])
def test_no_pair_settles_faster_than_the_best(loop):
    """Over a map of all stable pairs, and close by; the last two have no threefold root to be had."""
    gains, best = best_gains(loop)
    assert best == pytest.approx(rate(loop, gains), rel=1e-3)
    p, outer_l = np.linspace(0.0, gain_limit(loop, 0.0), 80), np.linspace(0.0, greatest_outer_l(loop), 160)
    assert decay_rates(loop, p[:, None], outer_l[None, :]).min() > 1.01 * best
    near = np.linspace(0.97, 1.03, 31)
    closer = decay_rates(loop, gains.inner_p * near[:, None], gains.outer_l * near[None, :]).min()
    assert closer > 1.01 * best


@pytest.mark.parametrize(("periods", "within"), [(0.0, 0.6), (1.0, 0.05), (5.0, 0.005), (10.5, 0.005), (25.0, 0.001)])
@pytest.mark.parametrize("lag_s", [0.0, 0.1])
def test_half_a_period_stands_for_sampling(periods, within, lag_s):
    """At 50 Hz: off by more than a half where there is no other delay, by less than 5 % from one period on."""
    delay_s, w, outer_l = periods / 50.0, 0.3, 3.0
    exact = SampledLoop(delay_s, 50.0, w, lag_s)
    limit = sampled_limit(exact, outer_l)
    assert gain_limit(Loop(delay_s + 0.01, w, lag_s), outer_l) == pytest.approx(limit, rel=within)
    for share, stable in ((0.2, True), (0.99, True), (1.01, False)):
        root = sampled_roots(exact, Gains(share * limit, outer_l))[0]
        assert (root.real < 0.0) == stable
    slow = Gains(0.2 * limit, 1.0)
    assert sampled_roots(exact, slow)[0].real == pytest.approx(rate(Loop(delay_s + 0.01, w, lag_s), slow), rel=0.02)


def test_a_sampled_loop_that_no_gain_steadies():
    assert sampled_limit(SampledLoop(0.5, 50.0, 0.45), 5.0) == 0.0 == gain_limit(Loop(0.51, 0.45), 5.0)


def test_what_cannot_be_designed_is_refused():
    for loop, gains, said in ((Loop(0.0, 0.4), Gains(1.0, 1.0), "delay of 0 s"), (Loop(0.2, 0.0), Gains(1, 1), "speed"),
                              (Loop(2.0, 1.0), Gains(1.0, 1.0), "quarter of a circle"),
                              (SMALL_KITE, Gains(-1.0, 1.0), "gain P of -1"),
                              (SMALL_KITE, Gains(1.0, math.nan), "gain L of nan")):
        with pytest.raises(ValueError, match=said):
            design(loop, gains)
