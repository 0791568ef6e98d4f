"""What the kite says by itself: heartbeat, status, state, position, texts."""

from math import cos, sin

from ..clock import HALF, MASK, ticks_add
from ..generated_enums import (
    KITE_MODE_STANDBY,
    KITE_STATUS_COASTING,
    KITE_STATUS_STALE,
    MAV_AUTOPILOT_GENERIC,
    MAV_MODE_FLAG_CUSTOM_MODE_ENABLED,
    MAV_MODE_FLAG_SAFETY_ARMED,
    MAV_STATE_ACTIVE,
    MAV_STATE_CRITICAL,
    MAV_STATE_STANDBY,
    MAV_TYPE_KITE,
)
from ..mavlink.generated_messages import (
    CURRENT_MODE,
    HEARTBEAT,
    KITE_STATE,
    LOCAL_POSITION_NED,
    NAMED_VALUE_FLOAT,
    STATUSTEXT,
    SYS_STATUS,
)
from ..parameters.generated_parameters import POSITION_HZ, STATE_HZ

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

    from ..autopilot import Autopilot
    from ..estimation.estimator import Estimator
    from ..mavlink.interface import Link

_SECOND = 1000000  # type: Final
_TWO_SECONDS = 2000000  # type: Final
_TEXTS = 8  # type: Final  # texts kept until they can be sent
_GEOFENCE = 1 << 20  # type: Final  # reported healthy: a ground station otherwise warns of a breach
_U16 = 65535  # type: Final
_SLOWEST_HZ = 0.0078125  # type: Final  # a beat must be shorter than half the wrap of the clock


# What is sent regularly, the shortest first where the link carries little.
_STREAMS = (SYS_STATUS, CURRENT_MODE, NAMED_VALUE_FLOAT, LOCAL_POSITION_NED, KITE_STATE)  # type: Final[tuple[int, ...]]
# Not all in one tick with the heartbeat.
_FIRST_US = (0, _SECOND // 4, _SECOND // 2, _SECOND // 8, 0)  # type: Final[tuple[int, ...]]
_USUAL_US = (_SECOND, 2 * _SECOND, _SECOND, 0, 0)  # type: Final[tuple[int, ...]]  # 0: a parameter says
_OF_KITE = (LOCAL_POSITION_NED, KITE_STATE)  # type: Final[tuple[int, ...]]  # need a sample
_FROM_START = (HEARTBEAT,) + _STREAMS  # type: Final[tuple[int, ...]]
_OF_MODE = 1  # type: Final  # places in _STREAMS
_OF_STATE = 4  # type: Final


class Telemetry:
    """Sends what is due; a heartbeat also at once when the mode changes. `autopilot` is read, never written.

    What the link has no room for is left out, except the heartbeat; texts wait.
    """

    def __init__(self, link: "Link", autopilot: "Autopilot") -> None:
        self._link = link
        self._autopilot = autopilot
        self._texts: list[tuple[int, bytes, int, int]] = []
        self._heartbeat_due: int | None = None
        self._due: list[int] = [0] * len(_STREAMS)
        self._asked: list[int] = [0] * len(_STREAMS)  # by a station [us]; 0 as usual, -1 not at all
        self._periods: list[int] = [0] * len(_STREAMS)  # at present, if no parameter changed since `_version`
        self._version: int = -1
        self._looked: int = 0  # when all streams were looked at
        self._last: int = 0  # the tick before this one
        self._quiet_us: int = 0  # from then on, in which none but the state's can be due; 0 where nobody knows
        self._mode: int = KITE_MODE_STANDBY  # when last looked at
        self._mode_is_told: bool = False  # CURRENT_MODE: who does not know it would miss its sequence numbers

    def say(self, severity: int, text: str) -> None:
        """Queue a text for the operator, at most 50 characters; the oldest gives way."""
        if len(self._texts) >= _TEXTS:
            self._texts.pop(0)
        self._texts.append((severity, text.encode(), 0, 0))

    def tell_mode(self) -> None:
        """Send CURRENT_MODE regularly from the next tick on: some station knows the messages about modes."""
        self._mode_is_told = True
        self._version = -1

    def send_due(self, now: int, uptime_us: int) -> None:
        """Send what is due at `now`: heartbeat first, then texts, then the rest."""
        due = self._due
        heartbeat_due = self._heartbeat_due
        if heartbeat_due is None:
            self._begin(now)
            heartbeat_due = now
        autopilot = self._autopilot
        mode = autopilot.modes.mode
        changed = self._mode != mode
        beats = not 0 < ((heartbeat_due - now + HALF) & MASK) - HALF <= _TWO_SECONDS  # see _time_left
        if beats:
            self._heartbeat_due = ticks_add(now, _SECOND)
        if beats or changed:
            self._send_heartbeat()
        if self._texts:
            budget = self._link.budget
            if budget.claim_text_room():
                budget.spend_on_text(self._link.send(STATUSTEXT, self._texts.pop(0)))
        if changed:
            self._wake()
            self._mode = mode
            if self._asked[_OF_MODE] >= 0:
                due[_OF_MODE] = now
        if self._version != autopilot.parameters.version:
            self._wake()
            self._look_up_periods()
        if (now - self._looked) & MASK < self._quiet_us:
            self._send_state_if_due(now)
        else:
            self._send_streams(now, uptime_us)
        self._last = now

    def _begin(self, now: int) -> None:
        self._heartbeat_due = now
        for index in range(len(_STREAMS)):
            self._due[index] = ticks_add(now, _FIRST_US[index])

    def _send_streams(self, now: int, uptime_us: int) -> None:
        """Send what is due of the regular messages but the heartbeat, and find out for how long nothing else is."""
        due = self._due
        budget = self._link.budget
        heard = self._autopilot.kite.has_heard()
        quiet_us = _SECOND if heard and self._periods[_OF_STATE] and not budget.is_crowded() else 0
        for index in range(len(due)):
            period = self._periods[index]
            if _STREAMS[index] in _OF_KITE:
                if not heard:
                    period = 0
                elif period and budget.is_crowded():
                    period <<= 1
            if not period:
                due[index] = now
                continue
            left_us = _time_left(due[index], period, now)
            if not left_us:
                due[index] = _next_due(due[index], period, now)
                left_us = _time_left(due[index], period, now)
                if budget.claim_room():
                    self.send(_STREAMS[index], now, uptime_us)
            if left_us < quiet_us and index != _OF_STATE:
                quiet_us = left_us
        self._looked = now
        self._quiet_us = quiet_us

    def _send_state_if_due(self, now: int) -> None:
        """What _send_streams does in a tick in which nothing but the state can be due."""
        due = self._due[_OF_STATE]
        budget = self._link.budget
        period = self._periods[_OF_STATE]
        if budget.is_crowded():
            period <<= 1
        if not 0 < ((due - now + HALF) & MASK) - HALF <= period + _SECOND:  # see _time_left
            self._due[_OF_STATE] = _next_due(due, period, now)
            if budget.claim_room():
                self._send_state(now)

    def _wake(self) -> None:
        """Look at all streams in this tick, as in the one before: then each that was off was due."""
        if self._quiet_us:
            self._quiet_us = 0
            for index in range(len(_STREAMS)):
                if not self._periods[index]:
                    self._due[index] = self._last

    def sends(self, message: int) -> bool:
        """True for a message that is sent regularly."""
        return message in _FROM_START

    def can_send(self, message: int) -> bool:
        """True if there is something to say in such a message."""
        return message not in _OF_KITE or self._autopilot.kite.has_heard()

    def interval(self, message: int) -> int:
        """The present interval [us] of a message that is sent regularly; 0 where it is not sent at present."""
        return _SECOND if message == HEARTBEAT else self._period_us(_STREAMS.index(message))

    def set_interval(self, message: int, interval_us: int) -> bool:
        """Send a message each `interval_us`; 0 is as usual, -1 not at all. False where that cannot be."""
        if message == HEARTBEAT:
            return interval_us in (0, _SECOND)
        self._asked[_STREAMS.index(message)] = interval_us
        self._version = -1
        return True

    def send(self, message: int, now: int, uptime_us: int) -> None:
        """Send one of the messages that are sent regularly."""
        autopilot = self._autopilot
        if message == KITE_STATE:
            self._send_state(now)
        elif message == LOCAL_POSITION_NED:
            self._send_position(autopilot.kite, uptime_us)
        elif message == NAMED_VALUE_FLOAT:
            self._link.send(NAMED_VALUE_FLOAT, (uptime_us // 1000, autopilot.turn_k.value, b"turn_k"))
        elif message == CURRENT_MODE:
            self._link.send(CURRENT_MODE, (autopilot.modes.mode, 0, 0))
        elif message == SYS_STATUS:
            self._send_status()
        else:
            self._send_heartbeat()

    def _look_up_periods(self) -> None:
        self._version = self._autopilot.parameters.version
        for index in range(len(_STREAMS)):
            self._periods[index] = self._period_us(index)

    def _period_us(self, index: int) -> int:
        """The interval of a stream [us], 0 where it is off."""
        asked = self._asked[index]
        if asked:
            return max(asked, 0)
        if _STREAMS[index] == CURRENT_MODE and not self._mode_is_told:
            return 0
        if _USUAL_US[index]:
            return _USUAL_US[index]
        rate_hz = self._autopilot.parameters.values[STATE_HZ if _STREAMS[index] == KITE_STATE else POSITION_HZ]
        return int(_SECOND / max(rate_hz, _SLOWEST_HZ)) if rate_hz else 0

    def _send_heartbeat(self) -> None:
        autopilot = self._autopilot
        modes = autopilot.modes
        base = MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        state = MAV_STATE_STANDBY
        if modes.mode != KITE_MODE_STANDBY:
            base |= MAV_MODE_FLAG_SAFETY_ARMED
            state = MAV_STATE_CRITICAL if modes.stale else MAV_STATE_ACTIVE
        self._link.send(HEARTBEAT, (modes.mode, MAV_TYPE_KITE, MAV_AUTOPILOT_GENERIC, base, state, 3))

    def _send_status(self) -> None:
        autopilot = self._autopilot
        bad_crc, unknown, lost, overflowed = self._link.counters()
        counts = (bad_crc, unknown, lost, overflowed + autopilot.inbox.refused)
        errors = tuple(min(count, _U16) for count in counts)
        sensors = (_GEOFENCE, _GEOFENCE, _GEOFENCE)
        load = min(1000, autopilot.timing.tick_us * 1000 // autopilot.period_us)
        self._link.send(SYS_STATUS, sensors + (load, _U16, -1, 0, 0) + errors + (-1, 0, 0, 0))

    def _send_state(self, now: int) -> None:
        autopilot = self._autopilot
        kite = autopilot.kite
        guidance = autopilot.guidance
        steering = autopilot.steering
        timing = autopilot.timing
        status = steering.status
        if autopilot.modes.stale:
            status |= KITE_STATUS_STALE
        if kite.coasting:
            status |= KITE_STATUS_COASTING
        self._link.send(
            KITE_STATE,
            (
                now, kite.sample_time, kite.azimuth, kite.elevation, kite.distance, kite.course, kite.heading,
                kite.airspeed, kite.tether_force, kite.steering, autopilot.target_course, guidance.cross_track,
                guidance.path_parameter, steering.asked, timing.overruns, kite.valid, status,
                timing.tick_us if timing.tick_us < _U16 else _U16, timing.worst_us if timing.worst_us < _U16 else _U16,
                kite.dropped if kite.dropped < _U16 else _U16, autopilot.modes.mode,
                timing.latest_us if timing.latest_us < _U16 else _U16,
            ),
        )

    def _send_position(self, kite: "Estimator", uptime_us: int) -> None:
        """Position and velocity [m, m/s] in the wire's frame: x, -y, -z of the wind frame."""
        frame = kite.frame
        up = kite.speed * cos(kite.course)
        across = kite.speed * sin(kite.course)
        self._link.send(
            LOCAL_POSITION_NED,
            (
                uptime_us // 1000, kite.distance * frame.x, -kite.distance * frame.y, -kite.distance * frame.z,
                up * frame.e1x + across * frame.e2x, -up * frame.e1y - across * frame.e2y, -up * frame.e1z,
            ),
        )


def _time_left(due: int, period: int, now: int) -> int:
    """Time until `due` [us]; 0 from then on, and where that lies further ahead than it can: the clock has jumped."""
    left_us = ((due - now + HALF) & MASK) - HALF
    return left_us if 0 < left_us <= period + _SECOND else 0


def _next_due(due: int, period: int, now: int) -> int:
    """When to send next, keeping the beat, unless more than a beat was missed."""
    due = (due + period) & MASK
    return due if (now - due) & MASK >= HALF else (now + period // 2) & MASK
