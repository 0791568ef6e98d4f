"""Warnings: what is wrong with the flight or the link, and what to do about it.

A silent link says nothing about the flight; stopped firmware or frozen sensors say nothing about the gains. Only
after these are ruled out is an oscillation blamed on the gain.
"""

import math
from collections import deque
from itertools import pairwise
from typing import NamedTuple

from ground.link.framing import Message
from ground.session import Session
from kite_analysis.angles import wrap
from protocol import dialect
from protocol.frame import read_header

SILENT_S = 3.0  # with rare messages
_LEAST_SILENT_S, _MISSED = 1.0, 10  # with frequent ones: this many in a row missing
_STOPPED_S = 1.0
_FROZEN_S = 1.0
_AT_ONCE = 3  # messages sent in one tick
_WINDOW_S = 10.0
_RECENT_S = 5.0
_UNHEARD_S = 8.0  # with a third lost each way, one such silence in 300 is chance
_LOSS = 0.1
_SPREAD_S = 0.2
_SWINGS_RAD = math.radians(60.0)
_FEW = 20  # fewer states than this in a window prove nothing


class _State(NamedTuple):
    """A state, and when it arrived [s]."""

    time_s: float
    state: dialect.MAVLink_kite_state_message


class _Stop(NamedTuple):
    """When the firmware resumed [s], and for how long it had stopped [s]."""

    ended_s: float
    seconds: float


class Advisor:
    """Watches the session's vehicle, and warns of what is wrong."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._states: deque[_State] = deque()
        self._sequence = 0
        self._stopped: _Stop | None = None
        session.connection.add_observer(self._observe)

    def warnings(self) -> list[str]:
        """One line for each present problem, the worst first."""
        silent = self._silence()
        if silent:
            return [silent]
        blind = [self._stopped_firmware(), self._frozen(), self._neutral()]
        flight = [] if any(blind) else [self._swinging(), self._saturated()]
        found = [self._unheard(), *blind, *flight, self._lossy(), self._overruns(), self._late(), self._slow(),
                 self._dropped(), self._broken_links(), self._others()]
        return [text for text in found if text]

    def _observe(self, time_s: float, message: Message, frame: bytes) -> None:
        if isinstance(message, dialect.MAVLink_kite_state_message):
            self._look_for_a_stop(time_s, message, read_header(frame).sequence)
            self._states.append(_State(time_s, message))
            while self._states[0].time_s < time_s - _WINDOW_S:
                self._states.popleft()

    def _look_for_a_stop(self, time_s: float, message: dialect.MAVLink_kite_state_message, sequence: int) -> None:
        """If no state arrived for a while but no message is missing, the firmware itself had stopped."""
        sent = (sequence - self._sequence) % 256
        self._sequence = sequence
        if not self._states:
            return
        gap_s = time_s - self._states[-1].time_s
        if gap_s > max(_STOPPED_S, _MISSED * self._usual_s()) and sent <= _AT_ONCE:
            self._stopped = _Stop(time_s, gap_s)

    def _usual_s(self) -> float:
        """Median time from one state to the next [s]."""
        steps_s = sorted(later.time_s - earlier.time_s for earlier, later in pairwise(self._states))
        return steps_s[len(steps_s) // 2] if steps_s else 0.0

    def _stopped_firmware(self) -> str | None:
        if self._stopped is None or self._session.connection.clock() - self._stopped.ended_s > _WINDOW_S:
            return None
        return (f"the firmware stopped for {self._stopped.seconds:.1f} s and the kite was not steered: "
                "PARK it, and check the board's power and load")

    def _frozen(self) -> str | None:
        """In flight, states arrive but their position does not change."""
        flying = [entry for entry in self._states if entry.state.mode != dialect.KITE_MODE_STANDBY]
        if len(flying) < _FEW:
            return None
        newest = flying[-1]
        since = next((entry for entry in reversed(flying) if _has_moved(entry.state, newest.state)), flying[0])
        frozen_s = newest.time_s - since.time_s
        if frozen_s < _FROZEN_S:
            return None
        return (f"position frozen for {frozen_s:.0f} s while messages arrive: "
                "check the sensors and their link, and fly by hand")

    def _silence(self) -> str | None:
        connection = self._session.connection
        last_s = connection.statistics.last_s
        silent_s = 0.0 if last_s is None else connection.clock() - last_s
        usual_hz = connection.statistics.rate_hz(connection.clock())
        if silent_s <= min(max(_LEAST_SILENT_S, _MISSED / max(usual_hz, 1e-3)), SILENT_S):
            return None
        problems = "; ".join(link.problem for link in self._session.links.all if link.problem)
        return (f"NO MESSAGE FOR {silent_s:.{silent_s < 10.0:d}f} s, all values below are old: "
                + (problems or "check the kite's power, the radio and the cable") + "; retrying")

    def _unheard(self) -> str | None:
        connection = self._session.connection
        unheard_s = connection.round_trip.unanswered_since(connection.clock())
        if unheard_s <= _UNHEARD_S:
            return None
        return (f"the kite has not answered for {unheard_s:.0f} s, so commands do not reach it: "
                "move closer to it, or add another --link")

    def _neutral(self) -> str | None:
        if not self._status(dialect.KITE_STATUS_STALE):
            return None
        return "samples are stale and steering is neutral: check the sensors and their link"

    def _swinging(self) -> str | None:
        errors = [wrap(state.course - state.target_course) for state in self._recent()
                  if state.mode == dialect.KITE_MODE_TRACK]
        if len(errors) < _FEW or math.sqrt(math.fsum(error**2 for error in errors) / len(errors)) < _SWINGS_RAD:
            return None
        return "the turning angle is far from its target: lower INNER_P (kite-ground tune), or go to PARK"

    def _lossy(self) -> str | None:
        connection = self._session.connection
        loss = connection.statistics.loss(connection.clock())
        if loss is None or loss <= _LOSS:
            return None
        return f"{loss:.0%} of the messages are lost: move closer, turn the antenna, or lower STATE_HZ"

    def _overruns(self) -> str | None:
        if not self._states or (grown := self._states[-1].state.overruns - self._states[0].state.overruns) <= 0:
            return None
        return f"overruns: {grown} in the last 10 s; lower STATE_HZ, or LOOP_HZ while disarmed"

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
            return "the kite is too slow to measure its course: steering by the last known course; PARK it"
        if self._status(dialect.KITE_STATUS_AIRSPEED_FLOOR):
            return ("airspeed is below AIRSPEED_MIN: the kite turns less than commanded; PARK it, or check the "
                    "airspeed sensor")
        return None

    def _dropped(self) -> str | None:
        if not self._states:
            return None
        grown = self._states[-1].state.samples_dropped - self._states[0].state.samples_dropped
        if grown <= 0:
            return None
        return f"implausible samples dropped: {grown} in the last 10 s; check the sensors"

    def _broken_links(self) -> str | None:
        problems = [link.problem for link in self._session.links.all if link.problem]
        return f"{problems[0]}; retrying" if problems else None

    def _others(self) -> str | None:
        if not (others := self._session.connection.others):
            return None
        return f"another vehicle is heard, system {min(others)}: choose one with --system"

    def _status(self, flag: int) -> bool:
        return bool(self._states and self._states[-1].state.status & flag)

    def _recent(self) -> list[dialect.MAVLink_kite_state_message]:
        now_s = self._session.connection.clock()
        return [entry.state for entry in self._states if entry.time_s >= now_s - _RECENT_S]


def _has_moved(earlier: dialect.MAVLink_kite_state_message, later: dialect.MAVLink_kite_state_message) -> bool:
    """Whether `later` reports a newer sample at a different position."""
    return (earlier.sample_time_us != later.sample_time_us
            and (earlier.azimuth, earlier.elevation) != (later.azimuth, later.elevation))
