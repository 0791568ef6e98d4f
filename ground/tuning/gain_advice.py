"""Advice on the inner loop's gain P for a given delay, alone and with the outer loop; verdict on the present gains."""

import math
from typing import Any, NamedTuple

from ground.errors import UsageError
from ground.vehicle.state import VehicleState
from kite_analysis.delay.characteristic_equation import Gains, Loop
from kite_analysis.delay.design_report import is_stable, paper_lines, whole_loop_dictionary, whole_loop_lines
from kite_analysis.delay.inner_loop import loop_delay, optimal_gain, stability_limit
from kite_analysis.delay.whole_loop import Design, design
from protocol.single_precision import float32

GAIN_NAME = "INNER_P"
OUTER_NAME = "OUTER_L"
RATE_NAME = "LOOP_HZ"
LEAST_SPEED_OVER_LENGTH = 1e-3  # a slower kite counts as not flying [1/s]


class GainAdvice(NamedTuple):
    """Times in s, rates in Hz, gains in 1/s. Those named `sampled` include half a loop period in the delay."""

    delay_s: float
    loop_hz: float
    loop_delay_s: float
    present: float
    limit: float
    optimum: float
    sampled_limit: float
    sampled_optimum: float
    whole: Design | None = None  # with the outer loop, if the kite's speed is known

    @property
    def proposal(self) -> float:
        """The gain to set: 1 / (e tau), as a float32."""
        return float32(self.optimum)


def advise(delay_s: float, loop_hz: float, present: float) -> GainAdvice:
    """Advice for dead time `delay_s` [s] of links and actuator, and a loop at `loop_hz` [Hz] with gain `present`.

    Raises:
        UsageError: the delay or the rate is not valid.
    """
    try:
        sampled_s = loop_delay(delay_s, loop_hz)
        return GainAdvice(delay_s, loop_hz, sampled_s, present, stability_limit(delay_s), optimal_gain(delay_s),
                          stability_limit(sampled_s), optimal_gain(sampled_s))
    except ValueError as error:
        raise UsageError(str(error)) from None


def with_outer_loop(advice: GainAdvice, speed_over_length: float, outer_l: float) -> GainAdvice:
    """The same advice with the whole loop's numbers, at `speed_over_length` [1/s] and the outer gain `outer_l`.

    Raises:
        UsageError: a kite this fast cannot be flown with this delay.
    """
    try:
        whole = design(Loop(advice.loop_delay_s, speed_over_length), Gains(advice.present, outer_l))
    except ValueError as error:
        raise UsageError(str(error)) from None
    return advice._replace(whole=whole)


def speed_over_length(state: VehicleState) -> float | None:
    """The kite's speed across the sky over its distance [1/s], as last reported; None if not flying or not reported."""
    position = state.position
    if position is None:
        return None
    distance = math.hypot(position.x, position.y, position.z)
    speed = math.hypot(position.vx, position.vy, position.vz)
    return speed / distance if distance and speed > LEAST_SPEED_OVER_LENGTH * distance else None


def verdict(advice: GainAdvice, gain: float) -> str:
    """How the loop behaves with `gain`, in words."""
    if gain <= 0.0:
        return "no steering: P is 0"
    if gain >= advice.limit:
        return "UNSTABLE: above the limit"
    if gain >= advice.sampled_limit:
        return "UNSTABLE: above the limit when sampling is included"
    if advice.whole and not is_stable(advice.whole):
        return f"UNSTABLE: above the limit together with {OUTER_NAME}"
    if gain > advice.optimum * 1.001:
        return "stable, but overshoots before it settles"
    if gain < advice.optimum * 0.999:
        return "stable, but settles more slowly than it could"
    return "the optimum"


def describe(advice: GainAdvice) -> list[str]:
    """The advice as lines of a table."""
    lines = paper_lines(advice.delay_s, advice.loop_hz, advice.present)
    if advice.whole:
        lines += ["", *whole_loop_lines(advice.whole, advice.delay_s, advice.loop_hz)]
    return lines


def as_dictionary(advice: GainAdvice) -> dict[str, Any]:
    """The advice as a dictionary, for scripts; keys carry units other than 1/s. `whole_loop` is None if not known."""
    whole = advice.whole and whole_loop_dictionary(advice.whole, advice.delay_s, advice.loop_hz)
    stable = 0.0 < advice.present < advice.sampled_limit and (advice.whole is None or is_stable(advice.whole))
    paper = {name: value for name, value in advice._asdict().items() if name != "whole"}
    return {**paper, "proposal": advice.proposal, "verdict": verdict(advice, advice.present), "stable": stable,
            "whole_loop": whole}


def check_proposal(advice: GainAdvice) -> None:
    """Raises UsageError if the optimum for tau alone would be unstable at this loop rate, or with this L."""
    if advice.proposal >= advice.sampled_limit:
        raise UsageError(f"not set: 1 / (e tau) = {advice.proposal:.4g} is unstable at {advice.loop_hz:g} Hz, "
                         f"where the limit is {advice.sampled_limit:.4g}: raise {RATE_NAME}, or set a lower gain")
    whole = advice.whole
    if whole and advice.proposal >= whole.limit:
        raise UsageError(f"not set: 1 / (e tau) = {advice.proposal:.4g} is unstable with {OUTER_NAME} = "
                         f"{whole.present.outer_l:.4g} at {whole.loop.speed_over_length:.3g} line lengths a second: "
                         f"the limit is {whole.limit:.4g}; lower {OUTER_NAME} first ({whole.best.outer_l:.3g} is best)")
