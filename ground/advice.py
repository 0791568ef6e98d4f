"""What is wrong with the flight or the link, in words that say what to do about it."""

import math
from collections import deque

from ground.framing import Message
from ground.session import Session
from protocol import dialect

SILENT_S = 3.0
_WINDOW_S = 10.0
_RECENT_S = 5.0
_UNHEARD_S = 8.0  # where a third is lost each way, one in 300 such stretches is chance
_LOSS = 0.1
_SPREAD_S = 0.2
_SWINGS_RAD = math.radians(60.0)
_FEW = 20  # states in a window


class Advisor:
    """Listens to the session's vehicle, and has `warnings`."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._states: deque[tuple[float, dialect.MAVLink_kite_state_message]] = deque()
        session.connection.add_observer(self._observe)

    def warnings(self) -> list[str]:
        """One line for each thing that is wrong at present, the worst first."""
        silent = self._silence()
        if silent:
            return [silent]
        found = [self._unheard(), self._neutral(), self._swinging(), self._lossy(), self._overruns(), self._late(),
                 self._saturated(), self._slow(), self._dropped(), self._broken_links(), self._others()]
        return [text for text in found if text]

    def _observe(self, time_s: float, message: Message, frame: bytes) -> None:
        if isinstance(message, dialect.MAVLink_kite_state_message):
            self._states.append((time_s, message))
            while self._states[0][0] < time_s - _WINDOW_S:
                self._states.popleft()

    def _silence(self) -> str | None:
        connection = self._session.connection
        last_s = connection.statistics.last_s
        silent_s = 0.0 if last_s is None else connection.clock() - last_s
        if silent_s <= SILENT_S:
            return None
        problems = "; ".join(link.problem for link in self._session.links.all if link.problem)
        return (f"NO MESSAGE FOR {silent_s:.0f} s, all below is old: " + (problems or "look at the kite's power, the "
                "radio and the cable") + "; it is tried again by itself")

    def _unheard(self) -> str | None:
        connection = self._session.connection
        unheard_s = connection.round_trip.unanswered_since(connection.clock())
        if unheard_s <= _UNHEARD_S:
            return None
        return (f"the kite has not answered for {unheard_s:.0f} s, so commands do not reach it: "
                "go nearer to it, or add another --link")

    def _neutral(self) -> str | None:
        if not self._status(dialect.KITE_STATUS_STALE):
            return None
        return "samples are stale and steering is neutral: look at the sensors and their link"

    def _swinging(self) -> str | None:
        errors = [math.remainder(state.course - state.target_course, math.tau) for state in self._recent()
                  if state.mode == dialect.KITE_MODE_TRACK]
        if len(errors) < _FEW or math.sqrt(math.fsum(error**2 for error in errors) / len(errors)) < _SWINGS_RAD:
            return None
        return "the turning angle is far from its target: lower INNER_P (kite-ground tune), or go to PARK"

    def _lossy(self) -> str | None:
        connection = self._session.connection
        loss = connection.statistics.loss(connection.clock())
        if loss is None or loss <= _LOSS:
            return None
        return f"{loss:.0%} of the messages are lost: go nearer, turn the antenna, or lower STATE_HZ"

    def _overruns(self) -> str | None:
        if not self._states or (grown := self._states[-1][1].overruns - self._states[0][1].overruns) <= 0:
            return None
        return f"{grown} ticks took too long of late: lower STATE_HZ, or LOOP_HZ while disarmed"

    def _late(self) -> str | None:
        connection = self._session.connection
        delay = connection.round_trip.summary(connection.clock(), 30.0)
        if delay is None or delay.answers < 5 or delay.spread_s <= max(_SPREAD_S, delay.median_s):
            return None
        return (f"answers take from {delay.low_s * 1e3:.0f} to {delay.high_s * 1e3:.0f} ms: the link is full or "
                "shared; lower STATE_HZ")

    def _saturated(self) -> str | None:
        recent = self._recent()
        held = [state for state in recent if state.status & dialect.KITE_STATUS_SATURATED]
        if len(recent) < _FEW or len(held) < len(recent) / 2:
            return None
        return "steering is at its limit most of the time: lower INNER_P, or fly a wider and higher eight"

    def _slow(self) -> str | None:
        if self._status(dialect.KITE_STATUS_COASTING):
            return "the kite is too slow to see where it flies: steering goes by the last course; PARK it"
        if self._status(dialect.KITE_STATUS_AIRSPEED_FLOOR):
            return "airspeed is below AIRSPEED_MIN: the kite turns less than asked; PARK it, or look at its sensor"
        return None

    def _dropped(self) -> str | None:
        if not self._states or (grown := self._states[-1][1].samples_dropped - self._states[0][1].samples_dropped) <= 0:
            return None
        return f"{grown} samples of late made no sense and were dropped: look at the sensors"

    def _broken_links(self) -> str | None:
        problems = [link.problem for link in self._session.links.all if link.problem]
        return f"{problems[0]}; it is tried again by itself" if problems else None

    def _others(self) -> str | None:
        if not (others := self._session.connection.others):
            return None
        return f"another vehicle is heard, system {min(others)}: --system chooses which one this is about"

    def _status(self, flag: int) -> bool:
        return bool(self._states and self._states[-1][1].status & flag)

    def _recent(self) -> list[dialect.MAVLink_kite_state_message]:
        now_s = self._session.connection.clock()
        return [state for time_s, state in self._states if time_s >= now_s - _RECENT_S]
