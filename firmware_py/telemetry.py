"""What the kite says by itself: heartbeat, status, state, position, texts."""

from math import cos, sin

from .generated_messages import (
    HEARTBEAT,
    KITE_MODE_STANDBY,
    KITE_STATE,
    KITE_STATUS_COASTING,
    KITE_STATUS_STALE,
    LOCAL_POSITION_NED,
    MAV_AUTOPILOT_GENERIC,
    MAV_MODE_FLAG_CUSTOM_MODE_ENABLED,
    MAV_MODE_FLAG_SAFETY_ARMED,
    MAV_STATE_ACTIVE,
    MAV_STATE_CRITICAL,
    MAV_STATE_STANDBY,
    MAV_TYPE_KITE,
    STATUSTEXT,
    SYS_STATUS,
)
from .generated_parameters import POSITION_HZ, STATE_HZ
from .ticks import ticks_add, ticks_diff

_SECOND = 1000000
_TEXTS = 8  # texts kept until they can be sent
_GEOFENCE = 1 << 20  # reported healthy: a ground station otherwise warns of a breach
_U16 = 65535
_SLOWEST_HZ = 0.0078125  # a beat must be shorter than half the wrap of the clock


class Telemetry:
    """Sends what is due. `autopilot` is read, never written."""

    def __init__(self, link, autopilot):
        self._link = link
        self._autopilot = autopilot
        self._texts = []
        self._heartbeat_due = None
        self._state_due = None
        self._position_due = None

    def say(self, severity, text):
        """Queue a text for the operator, at most 50 characters; the oldest gives way."""
        if len(self._texts) >= _TEXTS:
            self._texts.pop(0)
        self._texts.append((severity, text.encode(), 0, 0))

    def send_due(self, now, uptime_us):
        """Send what is due at `now`: heartbeat first, then texts, then the rest."""
        if self._heartbeat_due is None:
            self._heartbeat_due = self._state_due = self._position_due = now
        if ticks_diff(now, self._heartbeat_due) >= 0:
            self._heartbeat_due = ticks_add(now, _SECOND)
            self._send_heartbeat()
        if self._texts:
            self._link.send(STATUSTEXT, self._texts.pop(0))
        values = self._autopilot.parameters.values
        kite = self._autopilot.kite
        heard = kite.age_us(now) is not None
        if not heard or not values[STATE_HZ]:
            self._state_due = now
        elif ticks_diff(now, self._state_due) >= 0:
            self._state_due = _next_due(self._state_due, values[STATE_HZ], now)
            self._send_state(now)
        if not heard or not values[POSITION_HZ]:
            self._position_due = now
        elif ticks_diff(now, self._position_due) >= 0:
            self._position_due = _next_due(self._position_due, values[POSITION_HZ], now)
            self._send_position(kite, uptime_us)

    def _send_heartbeat(self):
        autopilot = self._autopilot
        modes = autopilot.modes
        base = MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        state = MAV_STATE_STANDBY
        if modes.mode != KITE_MODE_STANDBY:
            base |= MAV_MODE_FLAG_SAFETY_ARMED
            state = MAV_STATE_CRITICAL if modes.stale else MAV_STATE_ACTIVE
        self._link.send(HEARTBEAT, (modes.mode, MAV_TYPE_KITE, MAV_AUTOPILOT_GENERIC, base, state, 3))
        bad_crc, unknown, lost, overflowed = self._link.counters()
        refused = autopilot.inbox.refused
        counts = tuple(min(count, _U16) for count in (bad_crc, unknown, lost, overflowed + refused))
        sensors = (_GEOFENCE, _GEOFENCE, _GEOFENCE)
        load = min(1000, autopilot.tick_us * 1000 // autopilot.period_us)
        self._link.send(SYS_STATUS, sensors + (load, _U16, -1, 0, 0) + counts + (-1, 0, 0, 0))

    def _send_state(self, now):
        autopilot = self._autopilot
        kite = autopilot.kite
        guidance = autopilot.guidance
        steering = autopilot.steering
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
                guidance.path_parameter, steering.asked, autopilot.overruns, kite.valid, status,
                min(autopilot.tick_us, _U16), min(autopilot.tick_worst_us, _U16), min(kite.dropped, _U16),
                autopilot.modes.mode,
            ),
        )

    def _send_position(self, kite, uptime_us):
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


def _next_due(due, rate_hz, now):
    """When to send next, keeping the beat, unless more than a beat was missed."""
    period = int(_SECOND / max(rate_hz, _SLOWEST_HZ))
    due = ticks_add(due, period)
    return due if ticks_diff(now, due) < 0 else ticks_add(now, period // 2)
