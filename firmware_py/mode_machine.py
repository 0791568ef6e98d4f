"""Modes, arming, and what happens when something is missing: samples, the ground station, height."""

from math import radians

from .generated_messages import (
    KITE_MODE_MANUAL,
    KITE_MODE_PARK,
    KITE_MODE_STANDBY,
    KITE_MODE_TRACK,
    MAV_SEVERITY_CRITICAL,
    MAV_SEVERITY_INFO,
    MAV_SEVERITY_WARNING,
)
from .generated_parameters import GCS_LOST_TIME, MANUAL_TIME, PARK_ELEVATION, RESUME_TRACK
from .ticks import ticks_diff

_FRESH_US = 500000  # samples must keep coming for this long before they are trusted again
NAMES = ("STANDBY", "MANUAL", "PARK", "TRACK")


class ModeMachine:
    """`mode` is one of the KITE_MODE values; `stale` is True while steering must be neutral for want of samples.

    `say(severity, text)` is called with what the operator should read, at most 50 characters. `curve_problem` is why
    the target curve cannot be flown, or None.
    """

    def __init__(self, parameters, kite, say):
        self._values = parameters.values
        self._kite = kite
        self._say = say
        self.mode = KITE_MODE_STANDBY
        self.stale = False
        self.manual_steering = 0.0
        self._manual_time = 0
        self._resume = KITE_MODE_PARK
        self._fresh_since = 0
        self._was_missing = True
        self._station_heard = False
        self._station_time = 0

    def armed(self):
        """True in every mode but STANDBY."""
        return self.mode != KITE_MODE_STANDBY

    def arm(self, now, curve_problem):
        """Arm into PARK; return None, or why not. Nothing happens when armed already."""
        if self.armed():
            return None
        reason = "no samples from the kite" if self._kite.is_stale(now) else curve_problem
        if reason is None:
            self._enter(KITE_MODE_PARK, "armed")
        return reason

    def disarm(self):
        """Go to STANDBY."""
        if self.armed():
            self._enter(KITE_MODE_STANDBY, "disarmed")

    def recover(self):
        """Fly on in PARK after a reset in flight: armed, and neutral until samples have come for a while."""
        self.stale = True
        self._enter(KITE_MODE_PARK, "back after a reset", MAV_SEVERITY_CRITICAL)

    def command(self, mode, now, curve_problem):
        """Change to `mode` as an operator asked; return None, or why not."""
        if not 0 <= mode < len(NAMES):
            return "no such mode"
        if mode == KITE_MODE_STANDBY:
            self.disarm()
            return None
        if not self.armed():
            return "arm first"
        if self.stale:
            return "samples are stale"
        if mode == KITE_MODE_TRACK and mode != self.mode and curve_problem is not None:
            return curve_problem
        if mode == KITE_MODE_MANUAL:
            self._manual_time = now
            self.manual_steering = 0.0
        if mode != self.mode:
            self._enter(mode, "")
        return None

    def hear_station(self, now):
        """A ground station's heartbeat arrived."""
        self._station_heard = True
        self._station_time = now

    def hear_manual(self, steering, now):
        """MANUAL_CONTROL arrived with `steering` in [-1, 1]."""
        self.manual_steering = steering
        self._manual_time = now

    def update(self, now):
        """Look once a tick at everything that may be missing."""
        self._watch_samples(now)
        if self.stale or not self.armed() or self.mode == KITE_MODE_PARK:
            return
        values = self._values
        if self.mode == KITE_MODE_MANUAL and self._silent(self._manual_time, values[MANUAL_TIME], now):
            self._park("no MANUAL_CONTROL")
        elif self._station_heard and values[GCS_LOST_TIME] and self._silent(
            self._station_time, values[GCS_LOST_TIME], now
        ):
            self._park("ground station silent")
            self._station_heard = False
        elif self.mode == KITE_MODE_TRACK and self._too_low(values[PARK_ELEVATION]):
            self._park("too low")

    def _watch_samples(self, now):
        missing = self._kite.is_stale(now)
        if missing:
            if self.armed() and not self.stale:
                self.stale = True
                self._resume = self.mode
                self._say(MAV_SEVERITY_CRITICAL, "samples stale: steering neutral")
        elif self._was_missing:
            self._fresh_since = now
        elif self.stale and ticks_diff(now, self._fresh_since) >= _FRESH_US:
            self.stale = False
            if self.armed():
                back = self._resume if self._values[RESUME_TRACK] else KITE_MODE_PARK
                self._manual_time = now
                self.manual_steering = 0.0
                self._enter(back, "samples fresh again")
        self._was_missing = missing

    def _too_low(self, least_deg):
        return least_deg and self._kite.elevation < radians(least_deg)

    def _silent(self, since, limit_s, now):
        return ticks_diff(now, since) > int(limit_s * 1e6)

    def _park(self, why):
        self._enter(KITE_MODE_PARK, why, MAV_SEVERITY_WARNING)

    def _enter(self, mode, why, severity=MAV_SEVERITY_INFO):
        self.mode = mode
        if mode == KITE_MODE_STANDBY:
            self.stale = False
        self._say(severity, why + ": " + NAMES[mode] if why else "mode " + NAMES[mode])
