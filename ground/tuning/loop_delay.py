"""The delay in the control loop, from the telemetry of a flight.

By the turning-rate law, the turning angle changes over a tick by K times the integral of airspeed times steering, a
dead time tau earlier. (The integral includes that steering is held for a period: T/2 is not in tau.) The tau with the
best least-squares fit is the total of steering link, actuator, kite, sensors, sample link and estimator. The samples'
time stamps show a part of it, their age.

A slewing actuator turns the kite later than the dead time, the more so the further it has to move. If its limits are
known, the commanded steering passes through them first, and tau is the dead time alone; a measured heading then
replaces the course, as wind turns the course but not the heading.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

from kite_analysis.angles import wrap
from protocol import dialect

if TYPE_CHECKING:
    import numpy as np

    from kite_analysis.flights.record import FlightRecord

GREATEST_S = 1.5
_STEP_S = 0.01
_LONGEST_GAP_S = 0.25  # between states: after a longer one, states were lost
_LEAST_STATES = 100
_LEAST_FIT = 0.5
_PLAUSIBLE_AGE_S = 2.0
_SAME_SAMPLE_S = 1e-4


class Slewing(NamedTuple):
    """An actuator's rate limit [1/s] and saturation; 0 for none."""

    rate_per_s: float = 0.0
    saturation: float = 0.0


class LoopDelay(NamedTuple):
    """Times in s, None where unknown.

    `whole_s` is tau; `fit` is the fraction of the turning that it explains. `sample_age_s` is the median age of the
    sample at the tick, `sample_age_low_s` and `sample_age_high_s` its 5 % and 95 % quantiles. `states`: number used.
    """

    whole_s: float | None
    fit: float
    sample_age_s: float | None
    sample_age_low_s: float
    sample_age_high_s: float
    states: int

    @property
    def rest_s(self) -> float | None:
        """The total less the sample's age: steering link, actuator, kite and estimator [s]."""
        if self.whole_s is None or self.sample_age_s is None:
            return None
        return self.whole_s - self.sample_age_s


def measure_loop_delay(flight: "FlightRecord", actuator: Slewing = Slewing()) -> LoopDelay:  # noqa: B008
    """The delay in the loop from a stretch of flight in PARK or TRACK, made by `record_of_states`."""
    import numpy as np  # noqa: PLC0415

    count = len(flight.time_s)
    age = flight.sample_age_s
    age_s, low_s, high_s = (float(np.quantile(age, q)) for q in (0.5, 0.05, 0.95)) if count else (-1.0, 0.0, 0.0)
    whole_s, fit = _fit(flight, actuator) if count >= _LEAST_STATES else (None, 0.0)
    # A sample older than the whole delay: two independent clocks that happen to agree.
    greatest_s = _PLAUSIBLE_AGE_S if whole_s is None else whole_s + _STEP_S
    known = 0.0 <= age_s <= greatest_s
    return LoopDelay(whole_s, fit, age_s if known else None, low_s, high_s, count)


def _fit(flight: "FlightRecord", actuator: Slewing) -> tuple[float | None, float]:
    """The dead time [s] with which steering explains the turning best, or None; and the fraction explained."""
    import numpy as np  # noqa: PLC0415

    time_s = flight.time_s
    tick_s = np.diff(time_s)
    pull = flight.airspeed * _slewed(flight.set_steering, tick_s, actuator)
    between = 0.5 * np.diff(pull) * (tick_s - np.min(tick_s, initial=GREATEST_S))  # if states were lost on the way
    integral = np.concatenate(([0.0], np.cumsum(pull[:-1] * tick_s + between)))
    sampled_s, samples = _samples(flight)
    step_s = np.diff(sampled_s)
    convergence = np.sin(samples.elevation[:-1]) * wrap(np.diff(samples.azimuth))  # meridian convergence
    headed = bool(np.all(samples.further["valid"].astype(int) & dialect.KITE_VALID_HEADING))
    turned = wrap(np.diff(samples.heading if headed and actuator != Slewing() else samples.course)) + convergence
    good = (step_s > 0.0) & (step_s < _LONGEST_GAP_S) & (sampled_s[:-1] > time_s[0] + GREATEST_S)
    weight = np.sin(samples.heading) * np.cos(samples.elevation) / np.maximum(samples.airspeed, 1.0)
    known = np.stack([step_s, weight[:-1] * step_s], axis=1)[good]
    if np.count_nonzero(good) < _LEAST_STATES:
        return None, 0.0
    turned = turned[good]
    rest_of_turned, _ = _residual(known, turned)
    total = float(rest_of_turned @ rest_of_turned)

    def unexplained(delay_s: float) -> float:
        earlier = np.interp(sampled_s - delay_s, time_s, integral)
        left, gain = _residual(np.column_stack([np.diff(earlier)[good], known]), turned)
        return float(left @ left) if gain > 0.0 else total

    delays = np.arange(0.0, GREATEST_S, _STEP_S)
    left = np.array([unexplained(delay_s) for delay_s in delays])
    best = int(np.argmin(left))
    fit = 1.0 - float(left[best]) / total if total > 0.0 else 0.0
    if fit < _LEAST_FIT or best == len(delays) - 1:
        return None, fit
    return _between(delays, left, best), fit


def _samples(flight: "FlightRecord") -> "tuple[np.ndarray, FlightRecord]":
    """The rows with a new sample, and when each would have been seen at the median age [s].

    Firmware on its own clock sees some samples twice and others late: the turning between two ticks then does not
    belong to the time between them.
    """
    import numpy as np  # noqa: PLC0415

    sampled_s = flight.time_s - (flight.sample_age_s - np.median(flight.sample_age_s))
    new = np.concatenate([[True], np.diff(np.maximum.accumulate(sampled_s)) > _SAME_SAMPLE_S])
    return sampled_s[new], flight.rows(new)


def _slewed(commanded: Any, step_s: Any, actuator: Slewing) -> Any:
    """Mean position of an actuator without dead time, (n,), from each command to the next.

    The steering `commanded` (n,) is given at times that are `step_s` [s] (n - 1,) apart.
    """
    import numpy as np  # noqa: PLC0415

    most = actuator.saturation or np.inf
    wanted = np.clip(commanded, -most, most)
    if not actuator.rate_per_s:
        return wanted
    between, position = wanted.copy(), float(wanted[0])
    for index, seconds in enumerate(step_s):
        way = actuator.rate_per_s * max(float(seconds), 0.0)
        before, position = position, min(max(float(wanted[index]), position - way), position + way)
        between[index] = 0.5 * (before + position)
    return between


def _residual(columns: Any, target: Any) -> tuple[Any, float]:
    """The residual of `target` (n,) after a fit of the `columns` (n, m), and the factor of the first column."""
    import numpy as np  # noqa: PLC0415

    factors, *_ = np.linalg.lstsq(columns, target, rcond=None)
    return target - columns @ factors, float(factors[0])


def _between(delays: Any, left: Any, best: int) -> float:
    """The minimum [s] of the parabola through the best point and its neighbours."""
    if best == 0:
        return 0.0
    before, at, after = (float(left[index]) for index in (best - 1, best, best + 1))
    bend = before - 2.0 * at + after
    shift = 0.5 * (before - after) / bend if bend > 0.0 else 0.0
    return float(delays[best]) + _STEP_S * shift
