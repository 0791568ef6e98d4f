"""The verb `design` of `kite-sitl`: gains of the inner and the outer loop for a delay."""

import json
from argparse import Namespace
from pathlib import Path
from typing import Any

from kite_analysis.delay.characteristic_equation import Gains, Loop
from kite_analysis.delay.design_plots import plot_design
from kite_analysis.delay.design_report import paper_lines, whole_loop_dictionary, whole_loop_lines
from kite_analysis.delay.effective_delay import EffectiveDelay, effective_delay
from kite_analysis.delay.effective_delay import Path as LinkPath
from kite_analysis.delay.inner_loop import loop_delay, optimal_gain, stability_limit
from kite_analysis.delay.whole_loop import Design, design
from kite_analysis.delay.whole_periods import split
from sim_bridge.cli.notes import notice
from sim_bridge.cli.plot_option import plot_path, save_plot
from sim_bridge.errors import ScenarioError


def design_gains(options: Namespace) -> int:
    """`kite-sitl design`."""
    plot = plot_path(options, Path("design.png"))
    present = Gains(options.gain_p, options.gain_l)
    try:
        effective = _effective(options)
        delay_s = effective.delay_s if effective else options.delay
        loop_delay_s = loop_delay(delay_s, options.loop_hz)
        result = design(Loop(loop_delay_s, options.speed_over_length, options.lag), present)
    except (ValueError, ArithmeticError) as error:
        raise ScenarioError(f"design: {error}") from None
    if options.json:
        paper = {"limit": _at(stability_limit, delay_s), "optimum": _at(optimal_gain, delay_s),
                 "sampled_limit": stability_limit(loop_delay_s), "sampled_optimum": optimal_gain(loop_delay_s)}
        print(json.dumps({
            "delay_s": options.delay, "loop_hz": options.loop_hz, "effective": effective and effective._asdict(),
            "paper": paper, "whole_loop": whole_loop_dictionary(result, delay_s, options.loop_hz)}))
    else:
        lines = _link_lines(options, effective, loop_delay_s)
        lines += [*paper_lines(delay_s, options.loop_hz, present.inner_p), ""]
        print("\n".join([*lines, *whole_loop_lines(result, delay_s, options.loop_hz), *_purpose_lines(result)]))
    if plot:
        title = f"Whole loop: delay {delay_s:.3g} s, {options.speed_over_length:g} line lengths per second"
        save_plot(plot_design(result, title), plot)
        notice(f"plot: {plot}")
    return 0


def _purpose_lines(result: Design) -> list[str]:
    """What the optima are for: the kite that follows an eight by the plain law wants another P."""
    half = (f"P = {0.5 * result.limit:.3g}, half the limit at this L, is better for that" if result.limit
            else "but no P is stable at this L")
    return [
        "",
        "These optima settle fastest on a target at rest. An eight turns all the time: without FF_GAIN or prediction,",
        f"the larger P is, the closer the kite follows it; {half}.",
        "`kite-ground tune` measures it in flight.",
    ]


def _effective(options: Namespace) -> EffectiveDelay | None:
    """The delay that jitter and loss make of the given one; None where there is neither."""
    if not (options.jitter or options.loss):
        return None
    samples, steering = (LinkPath(delay_s, options.jitter, options.loss, options.loss_burst)
                         for delay_s in split(options.delay, 1.0 / options.loop_hz))
    return effective_delay(samples, steering, options.loop_hz)


def _link_lines(options: Namespace, effective: EffectiveDelay | None, loop_delay_s: float) -> list[str]:
    if effective is None:
        return []
    share = effective.scatter_s / loop_delay_s
    return [
        f"jitter of {options.jitter:g} s and loss of {options.loss:.0%} in each direction make {options.delay:.4g} s "
        f"act like {effective.delay_s:.4g} s",
        f"sample age varies by {effective.scatter_s:.3g} s RMS: limits are about {1.2 * share**2:.1%} on the safe side"
        + ("; too much for this model" if share > 1.0 / 3.0 else ""),
        "",
    ]


def _at(function: Any, delay_s: float) -> float | None:
    return function(delay_s) if delay_s else None
