"""The numbers of a gain design, as lines for a person and as a dictionary for a script."""

import math
from typing import Any

from kite_analysis.delay.characteristic_equation import Gains, Loop
from kite_analysis.delay.inner_loop import loop_delay, optimal_gain, stability_limit
from kite_analysis.delay.sampled_loop import SampledLoop, sampled_limit, sampled_roots
from kite_analysis.delay.whole_loop import Design

_MOST_PERIODS = 300  # of dead time, for which the sampled loop's roots are found quickly
_MOST_PERIODS_LIMIT = 5000  # the same for its limit


def paper_lines(delay_s: float, loop_hz: float, present_p: float) -> list[str]:
    """The paper's limit and optimum for dead time `delay_s` [s], 0 or more, without and with a loop at `loop_hz` [Hz].

    `present_p` [1/s] is compared with the limits. Raises ValueError as `kite_analysis.delay.inner_loop.loop_delay`.
    """
    sampled_s, tick = loop_delay(delay_s, loop_hz), "at tau'"

    def row(name: str, function: Any, form: str) -> str:
        at_tau = format(function(delay_s), form) if delay_s else "-"
        return f"{name:<36}{at_tau:>10}{function(sampled_s):>10{form}}"

    return [
        f"delay of links and actuator  tau  = {delay_s:.4g} s",
        f"with sampling at {f'{loop_hz:g} Hz':<10}  tau' = tau + T/2 = {sampled_s:.4g} s",
        "",
        f"{'gain P [1/s]':<36}{'at tau':>10}{tick:>10}",
        row("stability limit  pi / (2 tau)", stability_limit, ".4g"),
        row("optimum  1 / (e tau)", optimal_gain, ".4g"),
        row("present P, fraction of the limit", lambda tau_s: present_p / stability_limit(tau_s), ".0%"),
    ]


def whole_loop_lines(design: Design, delay_s: float, loop_hz: float) -> list[str]:
    """The whole loop's numbers; `delay_s` [s] and `loop_hz` [Hz] are those that design.loop's delay was made from."""
    loop, present, best = design.loop, design.present, design.best
    lag = f", actuator's lag {loop.lag_s:g} s" if loop.lag_s else ""
    limit = f"{design.limit:>10.4g}" if design.limit else f"{'no P is stable':>16}"
    exact = _exactly(_exact_limit(loop, delay_s, loop_hz, present.outer_l), design.limit, 0.01)
    exact_best = _exactly(_exact_rate(loop, delay_s, loop_hz, best), design.best_rate, 0.1)
    return [
        f"whole loop, {loop.speed_over_length:.3g} line lengths a second{lag}",
        f"{f'limit of P at the present L = {present.outer_l:.4g}':<36}{limit}{exact}",
        f"{'L above which no P is stable':<36}{design.greatest_outer_l:>10.4g}",
        f"{'best pair':<36}{_pair(best)}   {_pace(design.best_rate)}{exact_best}",
        f"{'present pair':<36}{_pair(present)}   {_pace(design.rate)}",
        f"{'margins of the present pair':<36}{_margins(design)}",
    ]


def whole_loop_dictionary(design: Design, delay_s: float, loop_hz: float) -> dict[str, Any]:
    """The same for a script: gains in 1/s, rates as real parts in 1/s; null where there is no such number."""
    loop, margins = design.loop, design.margins
    return {
        **loop._asdict(),
        "limit": design.limit,
        "sampled_limit": _finite(_exact_limit(loop, delay_s, loop_hz, design.present.outer_l)),
        "greatest_outer_l": design.greatest_outer_l,
        "best": {**design.best._asdict(), "rate": design.best_rate,
                 "sampled_rate": _exact_rate(loop, delay_s, loop_hz, design.best)},
        "present": {**design.present._asdict(), "rate": design.rate, "stable": is_stable(design),
                    "gain_margin": _finite(margins.gain), "delay_margin_s": _finite(margins.delay_s),
                    "sampled_rate": _exact_rate(loop, delay_s, loop_hz, design.present),
                    "roots": [[root.real, root.imag] for root in design.roots.tolist()]},
    }


def is_stable(design: Design) -> bool:
    """Whether errors decay with the present gains."""
    return design.rate < 0.0


def _pair(gains: Gains) -> str:
    return f"P = {gains.inner_p:<6.4g} L = {gains.outer_l:<6.4g}"


def _pace(rate: float) -> str:
    """What a rightmost root means."""
    if rate >= 0.0:
        return "UNSTABLE" if rate > 0.0 else "errors do not decay"
    return f"slowest mode decays at {-rate:.4g} 1/s"


def _margins(design: Design) -> str:
    gain, delay_s = design.margins
    if math.isinf(gain):
        return "-: no steering"
    if not is_stable(design):
        much = "unstable at any delay" if delay_s is None else f"{-delay_s:.3g} s too much delay"
        return f"none: {much}" + (f", or P {1.0 / gain:.3g} times too high" if gain else "")
    return f"{gain:.3g} times P ({20.0 * math.log10(gain):.1f} dB), {delay_s:.3g} s of delay"


def _exactly(exact: float | None, number: float, share: float) -> str:
    """A remark where the sampled loop's number is off by more than a share."""
    if exact is None or abs(exact - number) <= share * abs(number):
        return ""
    return f"   ({abs(exact):.4g} exact, with sampling)"


def _exact_limit(loop: Loop, delay_s: float, loop_hz: float, outer_l: float) -> float | None:
    """The sampled loop's limit; None with so many samples that sampling makes no difference to it."""
    if delay_s * loop_hz > _MOST_PERIODS_LIMIT:
        return None
    return sampled_limit(SampledLoop(delay_s, loop_hz, loop.speed_over_length, loop.lag_s), outer_l)


def _exact_rate(loop: Loop, delay_s: float, loop_hz: float, gains: Gains) -> float | None:
    """The sampled loop's rate; None where it has too many roots to find them in a moment."""
    if delay_s * loop_hz > _MOST_PERIODS:
        return None
    return float(sampled_roots(SampledLoop(delay_s, loop_hz, loop.speed_over_length, loop.lag_s), gains)[0].real)


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
