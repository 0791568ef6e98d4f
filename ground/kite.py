"""A connected kite, for scripts and notebooks: what kite-ground does, as functions.

    import ground

    with ground.connect("udpin:127.0.0.1:14550") as kite:
        kite.arm()
        kite.set_mode("TRACK")
        kite.wait_for(lambda state: abs(state.cross_track) < 0.1, timeout_s=60.0)
        kite.parameters["INNER_P"] = 1.8
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType

from ground.errors import NoAnswerError, UsageError
from ground.link.background import Background
from ground.link.links import Links, open_links
from ground.link.round_trip import DelaySummary
from ground.parameters.access import Parameters
from ground.session import Session
from ground.tuning.flown_law import FlownAdvice, advise_on, read_law
from ground.tuning.gain_advice import (
    GAIN_NAME,
    OUTER_NAME,
    RATE_NAME,
    GainAdvice,
    advise,
    speed_over_length,
    with_outer_loop,
)
from ground.tuning.in_flight import DELAY_MEASURE_S, DelayReport, StepResult, TuningFlight
from ground.tuning.trial import Trial
from ground.vehicle.history import StateHistory
from ground.vehicle.state import VehicleState
from protocol import dialect
from protocol.modes import MODE_NAMES

KiteState = dialect.MAVLink_kite_state_message
DEFAULT_LINK = "udpin:127.0.0.1:14550"
_DELAY_WINDOW_S = 60.0


@dataclass(frozen=True)
class LinkReport:
    """State of the links: messages per second, recent loss as a fraction, round trip, age of the last message [s]."""

    rate_hz: float
    loss: float | None
    round_trip: DelaySummary | None
    age_s: float


class Kite:
    """One kite, over one or several links. Made by `connect`; closes the links at the end of its `with` block.

    `parameters` reads and writes parameters, `state` is the latest state, `history` has all KITE_STATE messages.
    """

    def __init__(self, session: Session, background: bool) -> None:
        self.session = session
        self.state: VehicleState = session.state
        self.history = StateHistory()
        session.connection.add_observer(self.history.observe)
        self._serving = Background(session.connection)
        self.parameters = Parameters(session.parameters, self._serving)
        self._tuning = TuningFlight(session, self.history)
        if background:
            self._serving.start()

    @property
    def mode(self) -> str:
        """STANDBY, MANUAL, PARK or TRACK, from the last heartbeat."""
        return self.state.mode_name

    @property
    def armed(self) -> bool:
        """Whether the kite is armed, from the last heartbeat."""
        return bool(self.state.armed)

    def arm(self) -> None:
        """Arm, and return when the heartbeat confirms it. Raises VehicleError with the kite's reason."""
        with self._serving.held():
            self.session.commander.arm()

    def disarm(self) -> None:
        """Disarm, and return when the heartbeat confirms it; raises as `arm`."""
        with self._serving.held():
            self.session.commander.disarm()

    def set_mode(self, mode: str) -> None:
        """Change to the mode named `mode`; returns and raises as `arm`. Raises UsageError if there is no such mode."""
        number = next((value for value, name in MODE_NAMES.items() if name == mode.upper()), None)
        if number is None:
            raise UsageError(f"no mode {mode!r}: must be one of {', '.join(MODE_NAMES.values())}")
        with self._serving.held():
            self.session.commander.set_mode(number)

    def wait(self, seconds: float) -> None:
        """Wait for `seconds` [s] while the kite flies on; all messages go into `state` and `history`."""
        with self._serving.held():
            self.session.connection.wait_until(lambda: False, seconds)

    def wait_for(self, condition: Callable[[KiteState], bool], timeout_s: float,
                 what: str = "the condition") -> KiteState:
        """Wait for the first KITE_STATE that `condition` accepts, and return it.

        Raises:
            NoAnswerError: none did within `timeout_s` [s]; the message has `what` and the number of states.
        """
        seen = 0

        def accepts(message: dialect.MAVLink_message) -> bool:
            nonlocal seen
            if not isinstance(message, KiteState):
                return False
            seen += 1
            return condition(message)

        with self._serving.held():
            started_s = self.session.connection.clock()
            found = self.session.connection.wait_for(accepts, timeout_s)
            if isinstance(found, KiteState):
                return found
            if seen:
                raise NoAnswerError(f"{what}: did not happen within {timeout_s:g} s, in {seen} states of the kite")
            raise NoAnswerError(f"{what}: no KITE_STATE received: {self.session.connection.why_silent(started_s)}; "
                                "or is STATE_HZ 0?")

    def measure_delay(self, seconds: float = DELAY_MEASURE_S) -> DelayReport:
        """Measure the loop delay and the ground link's round trip for `seconds` [s] of flight. Raises NoAnswerError."""
        with self._serving.held():
            return self._tuning.measure_delay(seconds)

    def advise(self, delay_s: float) -> GainAdvice:
        """Limits and optima of the gains for settling, for dead time `delay_s` [s] without prediction.

        Includes the outer loop if the kite flies. Raises UsageError if the kite cannot be flown with this delay.
        """
        advice = advise(delay_s, self.parameters.get(RATE_NAME), self.parameters.get(GAIN_NAME))
        speed = speed_over_length(self.state)
        return with_outer_loop(advice, speed, self.parameters.get(OUTER_NAME)) if speed else advice

    def advise_as_flown(self, delay_s: float) -> FlownAdvice:
        """Limits, best P and a proposal for the present control law, including prediction and feed-forward.

        `delay_s` [s] as measured; if the kite follows its eight, the last 20 s of flight count. For settling under the
        plain law, `advise` has more. Raises UsageError if the delay is not valid.
        """
        with self._serving.held():
            law = read_law(self.session)
            advice = advise(delay_s, self.parameters.get(RATE_NAME), self.parameters.get(GAIN_NAME))
            flown = self._tuning.effect(DELAY_MEASURE_S) if law.eight else None
            return advise_on(law, advice, speed_over_length(self.state), self.parameters.get(OUTER_NAME), flown)

    def step_gain(self, factor: float, delay_s: float, name: str = GAIN_NAME,
                  measure_s: float | None = None) -> StepResult:
        """Multiply a gain by `factor` in TRACK and compare the flight before and after; see TuningFlight.step.

        The new value stays if this returns and the flight did not diverge; on any exception the old one is restored.
        """
        with self._serving.held(), Trial(self.session) as trial:
            result = self._tuning.step(trial, name, self.parameters.get(name) * factor, delay_s, measure_s)
            if not result.diverged:
                trial.keep()
        return result

    def link(self) -> LinkReport:
        """Present state of the links; the round trip (TIMESYNC) is over the last minute."""
        connection = self.session.connection
        with self._serving.held():  # reading the statistics drops what is outdated
            now_s = connection.clock()
            statistics = connection.statistics
            return LinkReport(
                statistics.rate_hz(now_s), statistics.loss(now_s),
                connection.round_trip.summary(now_s, _DELAY_WINDOW_S), now_s - (statistics.last_s or now_s))

    def close(self) -> None:
        """Close the links. May be called twice."""
        self._serving.stop()
        self.session.links.close()

    def __enter__(self) -> "Kite":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()


def connect(*links: str, system: int | None = None, timeout_s: float = 10.0,
            warn: Callable[[str], None] = print) -> Kite:
    """Connect to the kite over `links` (default: udpin:127.0.0.1:14550), and take a snapshot of its parameters.

    Each link is udpin:HOST:PORT, udpout:HOST:PORT or serial:DEVICE:BAUD. A thread keeps the connection alive between
    calls, so that the kite hears heartbeats and `history` has no gaps. `warn` receives one-line warnings.

    Raises:
        UsageError: a link cannot be opened, or no kite (of id `system`) is heard within `timeout_s` [s].
        NoAnswerError: the kite is heard, but does not send its parameters.
    """
    return connect_over(open_links(list(links) or [DEFAULT_LINK], time.monotonic, warn), system, timeout_s, warn)


def connect_over(links: Links, system: int | None = None, timeout_s: float = 10.0, warn: Callable[[str], None] = print,
                 background: bool = True) -> Kite:
    """As `connect`, over open `links` and on their clock. Without `background`, messages are handled only in calls."""
    session = Session(links, warn, system)
    try:
        session.find_vehicle(timeout_s)
        session.check_contract()
        kite = Kite(session, background)
        try:
            kite.parameters.take_snapshot()
        except BaseException:
            kite.close()
            raise
    except BaseException:
        links.close()
        raise
    return kite
