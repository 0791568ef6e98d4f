"""Advice on the inner loop's gain P for a given delay, and where the present gain stands."""

from typing import NamedTuple

from analysis.delay import loop_delay, optimal_gain, stability_limit
from ground.errors import UsageError
from protocol.parameter_table import float32

GAIN_NAME = "INNER_P"
RATE_NAME = "LOOP_HZ"


class GainAdvice(NamedTuple):
    """Times in s, rates in Hz, gains in 1/s. `sampled` is what holds with the loop's own half period counted in."""

    delay_s: float
    loop_hz: float
    loop_delay_s: float
    present: float
    limit: float
    optimum: float
    sampled_limit: float
    sampled_optimum: float

    @property
    def proposal(self) -> float:
        """The gain to write: 1 / (e tau), as a float32."""
        return float32(self.optimum)


def advise(delay_s: float, loop_hz: float, present: float) -> GainAdvice:
    """Advice for dead time `delay_s` [s] of links and actuator, and a loop at `loop_hz` [Hz] with gain `present`.

    Raises:
        UsageError: the delay or the rate is not one.
    """
    try:
        sampled_s = loop_delay(delay_s, loop_hz)
        return GainAdvice(delay_s, loop_hz, sampled_s, present, stability_limit(delay_s), optimal_gain(delay_s),
                          stability_limit(sampled_s), optimal_gain(sampled_s))
    except ValueError as error:
        raise UsageError(str(error)) from None


def verdict(advice: GainAdvice, gain: float) -> str:
    """What the loop does with `gain`, in words."""
    if gain <= 0.0:
        return "does not steer at all"
    if gain >= advice.limit:
        return "UNSTABLE: beyond the limit"
    if gain >= advice.sampled_limit:
        return "UNSTABLE: beyond the limit once sampling is counted"
    if gain > advice.optimum * 1.001:
        return "stable, but swings about the target before it settles"
    if gain < advice.optimum * 0.999:
        return "stable, but slower than it could be"
    return "the optimum"


def describe(advice: GainAdvice) -> list[str]:
    """The advice as lines of a table."""
    present, tick = advice.present, "at tau'"
    return [
        f"delay of links and actuator  tau  = {advice.delay_s:.4g} s",
        f"with sampling at {f'{advice.loop_hz:g} Hz':<10}  tau' = tau + T/2 = {advice.loop_delay_s:.4g} s",
        "",
        f"{'gain P [1/s]':<36}{'at tau':>10}{tick:>10}",
        f"{'stability limit  pi / (2 tau)':<36}{advice.limit:>10.4g}{advice.sampled_limit:>10.4g}",
        f"{'optimum  1 / (e tau)':<36}{advice.optimum:>10.4g}{advice.sampled_optimum:>10.4g}",
        f"{'present P, as share of the limit':<36}{present / advice.limit:>10.0%}"
        f"{present / advice.sampled_limit:>10.0%}",
        "",
        f"present {GAIN_NAME} = {present:.4g}: {verdict(advice, present)}",
    ]


def as_dictionary(advice: GainAdvice) -> dict[str, float | str | bool]:
    """The advice for a script; keys carry the units that are not 1/s."""
    return {**advice._asdict(), "proposal": advice.proposal, "verdict": verdict(advice, advice.present),
            "stable": 0.0 < advice.present < advice.sampled_limit}


def check_proposal(advice: GainAdvice) -> None:
    """Raises UsageError where the optimum for tau alone would be unstable in a loop as slow as this."""
    if advice.proposal >= advice.sampled_limit:
        raise UsageError(f"not written: 1 / (e tau) = {advice.proposal:.4g} is unstable at {advice.loop_hz:g} Hz, "
                         f"where the limit is {advice.sampled_limit:.4g}: raise {RATE_NAME}, or set a lower gain")
