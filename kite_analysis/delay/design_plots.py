"""Plot of a gain design: decay rate over (P, L), and the roots in the complex plane."""

import math
from typing import Any

import numpy as np

from kite_analysis.delay.characteristic_equation import Gains, Loop
from kite_analysis.delay.characteristic_roots import decay_rates, rightmost_roots
from kite_analysis.delay.inner_loop import optimal_gain, stability_limit
from kite_analysis.delay.whole_loop import Design, gain_limit
from kite_analysis.figures import new_figure

_PRESENT = "#d1495b"
_BEST = "#1f4e9c"
_PAPER = "#3d3d3d"
_UNSTABLE = "#e4e4e4"
_COLUMNS, _ROWS = 80, 60
_LINE_POINTS = 120
_LEVELS = 12
_ROOTS = 5
_NEAR = 8.0  # roots further off than this, in sizes of the largest of the first three, are not shown


def plot_design(design: Design, title: str) -> Any:
    """A figure with the map of the decay rate, the limit drawn in, and the rightmost roots.

    Raises:
        ExtraMissingError: matplotlib is not installed.
    """
    figure, _ = new_figure(11.0, 4.8)
    figure.clear()
    left, right = figure.subplots(1, 2, width_ratios=[1.35, 1.0])
    _draw_map(figure, left, design)
    _draw_roots(right, design)
    figure.suptitle(title, fontsize=11)
    return figure


def _draw_map(figure: Any, axes: Any, design: Design) -> None:
    loop = design.loop
    most_p, most_l = _extent(design)
    p, l_axis = np.linspace(0.0, most_p, _COLUMNS), np.linspace(0.0, most_l, _ROWS)
    rates = -decay_rates(loop, p[None, :], l_axis[:, None])
    axes.set_facecolor(_UNSTABLE)
    filled = axes.contourf(p, l_axis, rates, _levels(-design.best_rate), cmap="YlGnBu")
    bar = figure.colorbar(filled, ax=axes, pad=0.02, spacing="proportional")
    bar.set_label("decay rate of the slowest mode [1/s]")
    limit_l = np.linspace(0.0, min(most_l, design.greatest_outer_l), _LINE_POINTS)
    limits = [gain_limit(loop, value) for value in limit_l]
    axes.plot(limits, limit_l, color=_PRESENT, lw=1.8, label="limit of the whole loop")
    for function, style, name in ((stability_limit, "--", r"paper's limit $\pi/2\tau'$"),
                                  (optimal_gain, ":", r"paper's optimum $1/e\tau'$")):
        axes.axvline(function(loop.loop_delay_s), color=_PAPER, ls=style, lw=1.2, label=name)
    axes.set(xlabel="inner gain P [1/s]", ylabel="outer gain L", xlim=(0.0, most_p), ylim=(0.0, most_l))
    _mark(axes, design.best, "*", _BEST, "best pair", 13)
    _mark(axes, design.present, "o", _PRESENT, "present pair", 7)
    axes.fill_between([], [], color=_UNSTABLE, label="unstable")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2, fontsize=8, frameon=False)


def _extent(design: Design) -> tuple[float, float]:
    """How far the map goes in P and L: both pairs and the limits are on it, as far as that leaves something to see."""
    loop, best, present = design.loop, design.best, design.present
    limit = gain_limit(loop, 0.0)
    most_p = max(limit, min(max(present.inner_p, stability_limit(loop.loop_delay_s)), 2.0 * limit))
    most_l = max(4.0 * best.outer_l, 1.5 * present.outer_l, 0.3 * design.greatest_outer_l)
    return 1.08 * most_p, 1.05 * min(most_l, 1.5 * design.greatest_outer_l)


def _levels(most: float) -> Any:
    """Round numbers from 0 to the first above `most`; one step near the top, where the ridge is finer than the grid."""
    step = 10.0 ** math.floor(math.log10(most / _LEVELS))
    step *= next(factor for factor in (1.0, 2.0, 2.5, 5.0, 10.0) if factor * step * _LEVELS >= most)
    levels = step * np.arange(math.ceil(most / step) + 1)
    return np.append(levels[levels < 0.8 * most], levels[-1])


def _mark(axes: Any, gains: Gains, marker: str, colour: str, label: str, size: float) -> None:
    """Mark a pair, on the edge if it lies beyond."""
    (_, most_p), (_, most_l) = axes.get_xlim(), axes.get_ylim()
    p, outer_l = min(gains.inner_p, most_p), min(gains.outer_l, most_l)
    axes.plot(p, outer_l, marker, color=colour, mec="white", mew=1.0, ms=size, ls="none",
              label=f"{label}: P = {gains.inner_p:.3g}, L = {gains.outer_l:.3g}", clip_on=False, zorder=3)


def _draw_roots(axes: Any, design: Design) -> None:
    loop = design.loop
    best = rightmost_roots(loop, design.best, _ROOTS)
    present = rightmost_roots(loop, design.present, _ROOTS)
    shown = np.concatenate([present, best])
    near = _NEAR * max(np.abs(present[:3]).max(), np.abs(best[:3]).max())
    shown = shown[np.abs(shown) < near]
    left, high = 1.15 * shown.real.min(), 1.15 * max(np.abs(shown.imag).max(), 0.1 * near)
    right = max(0.12 * abs(left), 1.3 * shown.real.max())
    axes.axvspan(0.0, right, color=_UNSTABLE, zorder=0)
    axes.axvline(0.0, color=_PRESENT, lw=1.8)
    together = np.ptp(best[:3].real) < 0.01 * abs(best[0]) and len(best) > 2
    name = "best pair: a triple root" if together else "best pair"
    axes.plot(best.real, best.imag, "*", color=_BEST, ms=11, mec="white", mew=0.6, label=name)
    axes.plot(present.real, present.imag, "o", mfc="none", mec=_PRESENT, mew=1.6, ms=7, label="present pair")
    axes.set(xlabel="real part [1/s]", ylabel="imaginary part [1/s]", xlim=(left, right), ylim=(-high, high),
             title=_caption(loop))
    axes.title.set_fontsize(9)
    axes.grid(alpha=0.3)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2, fontsize=8, frameon=False)


def _caption(loop: Loop) -> str:
    lag = f", lag {loop.lag_s:g} s" if loop.lag_s else ""
    return rf"rightmost roots, $\tau'$ = {loop.loop_delay_s:.3g} s, $v/R$ = {loop.speed_over_length:.3g} 1/s{lag}"
