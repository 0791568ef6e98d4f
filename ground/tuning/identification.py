"""Identifies the kite in flight: K, gravity and the loop's delay from telemetry; proposes settings for them."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

from ground.errors import UsageError
from ground.session import Session
from ground.tuning.in_flight import TuningFlight
from ground.tuning.loop_delay import LoopDelay, measure_loop_delay
from ground.vehicle.history import StateHistory
from protocol import dialect
from protocol.parameter_table import Parameter

if TYPE_CHECKING:
    from kite_analysis.identification.actuator_fit import ActuatorFit
    from kite_analysis.identification.turning_rate_fit import LawFit

_WRONG_DELAY = 0.25  # relative error of the delay that the gains tolerate
_NO_SLEWING = 0.9995  # fraction of the turning that a pure delay explains if the actuator needs no time to slew
_RATE_SLACK = 0.1  # steering by which a rate-limited actuator lags, as in docs/delay.md


class Identified(NamedTuple):
    """The kite, as identified from its telemetry.

    `actuator`'s dead time counts from a sample of the usual age to the response: the loop's delay tau [s], of samples,
    steering link and actuator. `sample_age_s` is None if sensors and firmware have different clocks.
    """

    law: "LawFit"
    actuator: "ActuatorFit"
    sample_age_s: float | None
    delay_s: float
    delay_s_std: float


def identify_in_flight(session: Session, history: StateHistory, seconds: float, loop_hz: float) -> Identified:
    """Watch `seconds` [s] of flight, with a state for each tick of the loop, and fit law and actuator.

    Raises:
        UsageError: they cannot be identified from this flight, with the reason.
        NoAnswerError: the kite fell silent.
    """
    from kite_analysis.flights.description import FlightDataError  # noqa: PLC0415
    from kite_analysis.flights.telemetry import for_identification  # noqa: PLC0415
    from kite_analysis.identification.actuator_fit import identify_actuator  # noqa: PLC0415  (numpy, and slow to load)
    from kite_analysis.identification.turning_rate_fit import identify_law  # noqa: PLC0415

    with _every_state(session, loop_hz):
        TuningFlight(session, history).fly(seconds)
    flight = history.record(seconds)
    try:
        record = for_identification(flight, on_the_sensors_clock=True)
        law, actuator = identify_law(record), identify_actuator(record)
    except FlightDataError as error:
        raise UsageError(f"not identified: {error}; fly eights in TRACK, or measure longer (--seconds 60)") from error
    loop = measure_loop_delay(flight)
    delay_s = _dead_time(loop, actuator.dead_time_s, 0.5 / loop_hz)
    return Identified(law, actuator, loop.sample_age_s, delay_s, actuator.dead_time_s_std)


def _dead_time(loop: LoopDelay, sampled_s: float, half_s: float) -> float:
    """The loop's dead time [s], from the actuator's response and from the kite's turning.

    The response is seen in samples: `sampled_s`, to within `half_s` [s]. The turning gives dead time and slewing
    together: the dead time itself if steering explains all of the turning, otherwise an upper bound for it.
    """
    low_s, high_s = sampled_s - half_s, sampled_s + half_s
    if loop.whole_s is None or loop.whole_s <= low_s:
        return sampled_s
    if loop.fit > _NO_SLEWING:
        return min(loop.whole_s, high_s)
    return 0.5 * (low_s + min(high_s, loop.whole_s))


def propose(found: Identified, speed_over_length: float, loop_hz: float, table: dict[str, Parameter]
            ) -> dict[str, float]:
    """The kite's constants and the predictor's settings, followed by matching gains (docs/delay.md, Prediction).

    P = 1 / (e tau') and L = 1 / (4 w (tau' + 0.1 / rate limit)), for the delay that prediction leaves in the loop if it
    is 25 % off: tau' = tau / 4 + T / 2. `speed_over_length` w [1/s]. Values stay within the parameters' limits.
    """
    rate = found.actuator.rate_limit_per_s
    rest_s = _WRONG_DELAY * found.delay_s + 0.5 / loop_hz
    values = {
        "TURN_K": found.law.k_rad_per_m, "GRAVITY_C": found.law.gravity_m_s2, "TURN_OFFSET": found.law.offset_rad_s,
        "PRED_DELAY": found.delay_s, "PRED_RATE": rate or 0.0, "PRED_SAT": found.actuator.saturation or 0.0,
        "FF_GAIN": 1.0, "INNER_P": 1.0 / (math.e * rest_s),
        "OUTER_L": 1.0 / (4.0 * speed_over_length * (rest_s + (_RATE_SLACK / rate if rate else 0.0))),
    }
    return {name: table[name].nearest(value) for name, value in values.items()}


@contextmanager
def _every_state(session: Session, loop_hz: float) -> Iterator[None]:
    """Request a KITE_STATE at each tick; with fewer, identification is less accurate."""
    message = dialect.MAVLINK_MSG_ID_KITE_STATE
    session.commander.ask_interval(message, 1e6 / loop_hz)
    try:
        yield
    finally:
        session.commander.ask_interval(message, 0.0)
