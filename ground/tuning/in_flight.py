"""Tuning in flight: measures the delay in the loop, and the effect of a gain step on the flight."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from ground.errors import NoAnswerError, UsageError
from ground.link.connection import SILENCE_S
from ground.link.round_trip import DelaySummary
from ground.session import Session
from ground.tuning.loop_delay import LoopDelay, Slewing, measure_loop_delay
from ground.tuning.trial import Trial
from ground.vehicle.history import StateHistory
from kite_analysis.angles import wrap
from protocol import dialect
from protocol.modes import mode_name
from protocol.single_precision import float32

if TYPE_CHECKING:
    from kite_analysis.flights.record import FlightRecord

DELAY_MEASURE_S = 20.0
_TIMING_PERIOD_S = 0.2
_LOOK_S = 0.5
_SLOWEST = 10.0  # do not wait for a simulated flight this much slower than real time
_SETTLING_DELAYS = 10.0
_PERIODS = 2.0
_LEAST_S, _GREATEST_S = 10.0, 120.0
_DIVERGED_RAD, _DIVERGED_FACTOR = math.radians(60.0), 3.0
_STRAYED_RAD = math.radians(20.0)  # cross-track error
_WATCHED_S = 3.0

Told = Callable[[str], None]


class DelayReport(NamedTuple):
    """The loop's delay as measured in flight, and the ground link's round trip, which is not part of the loop."""

    loop: LoopDelay
    round_trip: DelaySummary | None


class Effect(NamedTuple):
    """RMS of cross-track and turning-angle error [rad] over `seconds` of flight."""

    cross_track_rad: float
    turning_rad: float
    seconds: float


class StepResult(NamedTuple):
    """A gain step from `old` to `new`, with the errors before and after. `diverged`: the step was undone at once."""

    name: str
    old: float
    new: float
    before: Effect
    after: Effect
    diverged: bool


class TuningFlight:
    """Watches a flight through `session` and its `history`, both of which must be fed by the same connection."""

    def __init__(self, session: Session, history: StateHistory) -> None:
        self._session, self._history = session, history

    def measure_delay(self, seconds: float = DELAY_MEASURE_S) -> DelayReport:
        """Measure the delays over the next `seconds` [s] of the kite's time. Raises as `fly`.

        If prediction is on, the actuator's limits are known (`PRED_RATE`, `PRED_SAT`), and the delay is the dead time
        alone, as `PRED_DELAY` is.
        """
        connection = self._session.connection
        actuator = self._actuator()
        usual_s, connection.timing_period_s = connection.timing_period_s, _TIMING_PERIOD_S
        started_s = connection.clock()
        try:
            self.fly(seconds)
            connection.wait_until(lambda: False, connection.round_trip.timeout_s)  # for the last answers
        finally:
            connection.timing_period_s = usual_s
        now_s = connection.clock()
        return DelayReport(measure_loop_delay(self._history.record(seconds), actuator),
                           connection.round_trip.summary(now_s, now_s - started_s))

    def effect(self, seconds: float) -> Effect:
        """The errors over the last `seconds` [s] of the flight."""
        return measure_effect(self._history.record(seconds))

    def look(self, seconds: float) -> Effect:
        """The errors over the next `seconds` [s]. Raises as `fly`."""
        self.fly(seconds)
        return self.effect(seconds)

    def step(self, trial: Trial, name: str, new: float, delay_s: float, measure_s: float | None = None,
             told: Told = lambda text: None) -> StepResult:
        """Change `name` to `new` in TRACK, within `trial`; measure the errors before, and after settling.

        Each is measured for `measure_s` [s] of the kite's time, by default two rounds of the eight; settling takes one
        round, or ten times the loop's delay `delay_s` [s] if that is longer. If the flight diverges, the trial is
        undone at once.

        Raises:
            UsageError: the kite is not in TRACK, or not flying its eight.
            VehicleError: the new value was refused.
            NoAnswerError: the kite fell silent.
        """
        self._check_track()
        period_s = self._period(told)
        measure_s = measure_s or min(max(_PERIODS * period_s, _LEAST_S), _GREATEST_S)
        told(f"an eight takes {period_s:.1f} s: measuring for {measure_s:.0f} s before the step")
        before = self.look(measure_s)
        old = trial.set(name, new)
        settle_s = max(period_s, _SETTLING_DELAYS * delay_s)
        told(f"{name} = {new:.4g}, acknowledged; {settle_s:.0f} s to settle, then {measure_s:.0f} s to measure")
        after, diverged = self.try_out(trial, before, settle_s, measure_s)
        return StepResult(name, old, float32(new), before, after, diverged)

    def try_out(self, trial: Trial, before: Effect, settle_s: float, measure_s: float) -> tuple[Effect, bool]:
        """Fly with the values of `trial`; return the errors over the last `measure_s` [s], and whether it diverged.

        If so, the trial is undone at once. `before` are the errors without it. Raises as `fly`.
        """
        flown_s = self.fly(settle_s + measure_s, stop=lambda: self._diverges(before))
        diverged = flown_s < settle_s + measure_s
        after = self.effect(min(flown_s, measure_s))
        if diverged:
            trial.undo()
        return after, diverged

    def fly(self, seconds: float, stop: Callable[[], bool] = lambda: False) -> float:
        """Let `seconds` [s] of the kite's time pass, or fewer if `stop` becomes true; return how many passed.

        Raises:
            NoAnswerError: the kite fell silent, or sends no KITE_STATE.
            UsageError: its mode changed.
        """
        connection = self._session.connection
        started_s = connection.clock()
        mode, flown_s, last_s = self._session.state.mode, 0.0, self._history.newest_s
        while flown_s < seconds:
            connection.wait_until(lambda: False, min(_LOOK_S, max(seconds - flown_s, 0.01)))
            newest_s = self._history.newest_s
            last_s = newest_s if last_s is None else last_s
            flown_s = newest_s - last_s if newest_s is not None and last_s is not None else 0.0
            elapsed_s = connection.clock() - started_s
            if connection.silence_s(started_s) >= SILENCE_S or elapsed_s > _SLOWEST * seconds + SILENCE_S:
                raise NoAnswerError(f"no flight states: {connection.why_silent(started_s)}; or is STATE_HZ 0?")
            if mode is not None and self._session.state.mode != mode:
                raise UsageError(f"the kite went from {mode_name(mode)} to {self._session.state.mode_name}: "
                                 "measurement discarded")
            if flown_s > 0.0 and stop():
                break
        return flown_s

    def _actuator(self) -> Slewing:
        fetch = self._session.parameters.fetch
        return Slewing(fetch("PRED_RATE"), fetch("PRED_SAT")) if fetch("PRED_DELAY") else Slewing()

    def _check_track(self) -> None:
        if self._session.state.mode != dialect.KITE_MODE_TRACK:
            raise UsageError(f"a step is measured in TRACK, and the kite is in {self._session.state.mode_name}: "
                             "run kite-ground mode track")

    def _period(self, told: Told) -> float:
        """The period of the eight [s]."""
        period_s = eight_period(self._history.record())
        if period_s is None:
            told("watching the eight")
            self.fly(_LEAST_S)
            period_s = eight_period(self._history.record(_LEAST_S))
        if period_s is None:
            raise UsageError("the kite is not flying its eight: nothing to measure")
        return period_s

    def _diverges(self, before: Effect) -> bool:
        now = self.effect(_WATCHED_S)
        return now.seconds > 0.5 * _WATCHED_S and (
            now.turning_rad > max(_DIVERGED_RAD, _DIVERGED_FACTOR * before.turning_rad)
            or now.cross_track_rad > max(_STRAYED_RAD, _DIVERGED_FACTOR * before.cross_track_rad))


def measure_effect(flight: "FlightRecord") -> Effect:
    """RMS errors over the whole of `flight`."""
    import numpy as np  # noqa: PLC0415

    if not len(flight.time_s):
        return Effect(math.nan, math.nan, 0.0)
    error = wrap(flight.course - flight.target_course)
    return Effect(float(np.sqrt(np.mean(flight.cross_track**2))), float(np.sqrt(np.mean(error**2))),
                  float(np.ptp(flight.time_s)))


def eight_period(flight: "FlightRecord") -> float | None:
    """The period of the eight [s], from the path parameter's progress over at least 5 s; None if unknown."""
    import numpy as np  # noqa: PLC0415

    tracking = flight.mode == dialect.KITE_MODE_TRACK
    time_s, path = flight.time_s[tracking], np.unwrap(flight.path_parameter[tracking])
    if len(time_s) < 2 or time_s[-1] - time_s[0] < 0.5 * _LEAST_S:
        return None
    rate = abs(path[-1] - path[0]) / (time_s[-1] - time_s[0])
    return float(2.0 * np.pi / rate) if rate > 2.0 * np.pi / _GREATEST_S else None


def parse_step(text: str) -> float:
    """The factor for a step such as "+10%" or "-5 %".

    Raises:
        ValueError: it is not a percentage, is 0, or is outside -90 % to +100 %.
    """
    number = text.strip().removesuffix("%").strip()
    try:
        percent = float(number)
    except ValueError:
        raise ValueError(f"{text!r} is not a step: write +10% or -5%") from None
    if not -90.0 <= percent <= 100.0 or percent == 0.0:
        raise ValueError(f"{text!r}: must be from -90% to +100%, and not 0")
    return 1.0 + percent / 100.0
