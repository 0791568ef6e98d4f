"""The delay theory against closed forms, against its own characteristic equation, and against simulated loops."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kite_analysis.delay.inner_loop import decay_rate, lambert_w_real_part, loop_delay, optimal_gain, stability_limit

delays = st.floats(0.001, 10.0)


def simulate(gain: float, tau_s: float, duration_s: float, steps: int = 400) -> np.ndarray:
    """|e| over time for de/dt (t) = -P e(t - tau), from e = 1, by the trapezoidal rule with `steps` steps per tau."""
    step_s = tau_s / steps
    error = np.ones(steps + 1 + round(duration_s / step_s))  # the first steps + 1 values are the history up to t = 0
    for now in range(steps, len(error) - 1):
        error[now + 1] = error[now] - gain * step_s * (error[now - steps] + error[now - steps + 1]) / 2.0
    return np.abs(error[steps:])


def growth_rate(error: np.ndarray, duration_s: float) -> float:
    """Slope of the logarithm of |e|'s envelope [1/s], over the peaks of the second half of an oscillation."""
    inner = error[1:-1]
    peaks = 1 + np.flatnonzero((inner > error[:-2]) & (inner >= error[2:]))
    peaks = peaks[peaks > len(error) // 2]
    assert len(peaks) > 5
    return np.polyfit(peaks * duration_s / (len(error) - 1), np.log(error[peaks]), 1)[0]


def test_the_papers_example():
    """tau = 0.2 s in Baayen (2012), section "Simulation results": P = 10 is unstable, P = 1 / (e tau) is not."""
    assert stability_limit(0.2) == pytest.approx(7.853982, abs=1e-6)
    assert optimal_gain(0.2) == pytest.approx(1.839397, abs=1e-6)
    assert decay_rate(10.0, 0.2) > 0.0
    assert decay_rate(optimal_gain(0.2), 0.2) == pytest.approx(-1.0 / 0.2, rel=1e-6)
    assert loop_delay(0.2, 50.0) == pytest.approx(0.21)


@given(delays)
def test_at_the_limit_errors_neither_grow_nor_shrink(tau_s):
    limit = stability_limit(tau_s)
    assert decay_rate(limit, tau_s) * tau_s == pytest.approx(0.0, abs=1e-9)
    assert decay_rate(0.99 * limit, tau_s) < 0.0 < decay_rate(1.01 * limit, tau_s)


@given(delays, st.floats(0.0, 8.0))
def test_no_gain_converges_faster_than_the_optimum(tau_s, share):
    best = decay_rate(optimal_gain(tau_s), tau_s) * tau_s
    assert decay_rate(share * optimal_gain(tau_s), tau_s) * tau_s >= best - 1e-6


@given(delays, st.floats(1.01, 20.0))
def test_the_rate_belongs_to_a_root_of_the_characteristic_equation(tau_s, share):
    """Beyond the optimum the root is complex; |s| = P exp(-Re(s) tau) gives its imaginary part."""
    gain = share * optimal_gain(tau_s)
    real = decay_rate(gain, tau_s)
    root = complex(real, math.sqrt((gain * math.exp(-real * tau_s)) ** 2 - real**2))
    assert abs(root + gain * np.exp(-root * tau_s)) * tau_s < 1e-8


def test_the_principal_branch_lies_furthest_right():
    """Lemma 3.1, over the values of a that gains up to twice the limit take."""
    a = np.linspace(-math.pi, -1e-3, 500)
    principal = lambert_w_real_part(a, 0)
    assert principal.shape == a.shape
    for branch in (-3, -2, -1, 1, 2, 3):
        assert np.all(lambert_w_real_part(a, branch) <= principal + 1e-12)
    assert lambert_w_real_part(np.array([math.e, 0.0]), 0) == pytest.approx([1.0, 0.0])


@pytest.mark.parametrize("share", [0.5, 0.97, 1.03, 1.3])
def test_a_simulated_loop_grows_and_shrinks_as_said(share):
    tau_s, duration_s = 0.2, 8.0
    gain = share * stability_limit(tau_s)
    measured = growth_rate(simulate(gain, tau_s, duration_s), duration_s)
    assert measured == pytest.approx(decay_rate(gain, tau_s), rel=0.01, abs=0.003)
    assert (measured < 0.0) == (share < 1.0)


@pytest.mark.parametrize("periods", [2, 5, 20])
def test_a_sampled_loop_has_its_limit_at_tau_and_half_a_period(periods):
    """A hold of one period, and tau of whole periods: e[n+1] = e[n] - P T e[n - m], with roots z."""
    period_s = 0.02
    limit = stability_limit(loop_delay(periods * period_s, 1.0 / period_s))
    for share, stable in ((0.98, True), (1.02, False)):
        roots = np.roots([1.0, -1.0, *[0.0] * (periods - 1), share * limit * period_s])
        assert (np.abs(roots).max() < 1.0) == stable


@pytest.mark.parametrize("tau_s", [0.0, -0.1, math.nan, math.inf])
def test_a_delay_that_is_none_is_refused(tau_s):
    for function in (stability_limit, optimal_gain, lambda tau_s: decay_rate(1.0, tau_s)):
        with pytest.raises(ValueError, match="longer than zero"):
            function(tau_s)
    for rate_hz in (0.0, -1.0, math.nan):
        with pytest.raises(ValueError, match="loop rate"):
            loop_delay(0.1, rate_hz)
