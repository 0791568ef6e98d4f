"""Delays that fall into whole periods of the loop."""


def split(delay_s: float, period_s: float) -> tuple[float, float]:
    """Delays [s] (samples, steering) that a total of `delay_s` [s] falls into, as on the simulated control path.

    Half each, the samples' rounded down to whole periods of the loop, the rest on the steering.
    """
    samples_s = whole_periods(delay_s / 2, period_s)
    return samples_s, delay_s - samples_s


def whole_periods(delay_s: float, period_s: float) -> float:
    """`delay_s` [s] rounded down to whole periods of the loop, which sees a sample only then."""
    return int(delay_s / period_s + 1e-9) * period_s
