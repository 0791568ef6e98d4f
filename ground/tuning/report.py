"""The measurements of `tune`, as lines for the user and as a dictionary for scripts."""

import math

from ground.tuning.gain_advice import GainAdvice
from ground.tuning.in_flight import DelayReport, Effect, StepResult

_SCALE = 50  # columns


def delay_lines(report: DelayReport) -> list[str]:
    """The measured parts of the delay, those that count and those that do not."""
    loop, trip = report.loop, report.round_trip
    lines = ["loop delay, counted:"]
    if loop.sample_age_s is None:
        lines.append("  sample age at the tick               -       sensor and firmware clocks differ")
    else:
        lines.append(f"  sample age at the tick          {loop.sample_age_s:8.3f} s   90 % from "
                     f"{loop.sample_age_low_s:.3f} to {loop.sample_age_high_s:.3f} s")
    if loop.rest_s is not None:
        lines.append(f"  steering link, actuator, kite   {loop.rest_s:8.3f} s   the rest")
    if loop.whole_s is not None:
        lines.append(f"  total, steering to turn         {loop.whole_s:8.3f} s   explains {loop.fit:.1%}")
    lines.append("not counted:")
    lines.append("  half a loop period, which tau' includes")
    if trip is None:
        lines.append("  ground link: no answer")
    else:
        lost = "" if trip.loss is None else f", {trip.loss:.0%} unanswered"
        lines.append(f"  ground link, round trip         {trip.median_s:8.3f} s   90 % from {trip.low_s:.3f} to "
                     f"{trip.high_s:.3f} s{lost}")
    return lines


def delay_as_dictionary(report: DelayReport) -> dict[str, object]:
    """The delays as a dictionary, for scripts; times in s."""
    trip = report.round_trip
    return {**report.loop._asdict(), "rest_s": report.loop.rest_s, "ground_round_trip": trip and trip._asdict()}


def scale_line(advice: GainAdvice) -> str:
    """The present gain (P) on a scale from 0 over the optimum (o) to the limit, all including sampling."""
    scale = ["-"] * _SCALE
    scale[min(int(advice.sampled_optimum / advice.sampled_limit * _SCALE), _SCALE - 1)] = "o"
    at = advice.present / advice.sampled_limit
    if 0.0 <= at < 1.0:
        scale[int(at * _SCALE)] = "P"
    return f"0 [{''.join(scale)}] {advice.sampled_limit:.4g}{' P' if at >= 1.0 else ''}   o is the optimum"


def effect_lines(result: StepResult) -> list[str]:
    """The flight before and after a step."""
    lines = [f"{'':<26}{'before':>10}{'after':>10}", f"{result.name:<26}{result.old:>10.4g}{result.new:>10.4g}"]
    for name, column in (("cross-track error, RMS", 0), ("turning-angle error, RMS", 1)):
        before, after = math.degrees(result.before[column]), math.degrees(result.after[column])
        change = f"   {after / before - 1.0:+.0%}" if before else ""
        lines.append(f"{name:<26}{before:>6.2f} deg{after:>6.2f} deg{change}")
    lines.append(f"{'measured for':<26}{_seconds(result.before)}{_seconds(result.after)}")
    if result.diverged:
        lines.append(f"the flight diverged: {result.name} = {result.old:.4g} restored, acknowledged by the kite")
    return lines


def _seconds(effect: Effect) -> str:
    return f"{effect.seconds:>8.0f} s"
