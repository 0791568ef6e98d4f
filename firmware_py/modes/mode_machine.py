"""Modes, arming, and what happens when something is missing: samples, the ground station, height."""

from math import radians

from ..generated_enums import (
    KITE_MODE_MANUAL,
    KITE_MODE_PARK,
    KITE_MODE_STANDBY,
    KITE_MODE_TRACK,
    MAV_SEVERITY_CRITICAL,
    MAV_SEVERITY_INFO,
    MAV_SEVERITY_WARNING,
)
from ..parameters.generated_parameters import GCS_LOST_TIME, MANUAL_TIME, PARK_ELEVATION, RESUME_TRACK

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Final

    from ..estimation.estimator import Estimator
    from ..parameters.values import Parameters

_FRESH_US = 500000  # type: Final  # samples must keep coming for this long before they are trusted again
_NEVER = -1  # type: Final
_FOREVER_US = 1 << 29  # type: Final  # silences are counted no further
NAMES = ("STANDBY", "MANUAL", "PARK", "TRACK")  # type: Final[tuple[str, ...]]


class ModeMachine:
    """`mode` is one of the KITE_MODE values; `stale` is True while an armed kite has no samples to be steered by.

    What follows from both is a table in docs/modes.md. `say(severity, text)` is called with what the operator should
    read, at most 50 characters. Silences are counted up tick by tick: the clock may wrap, or jump.
    """

    def __init__(self, parameters: "Parameters", kite: "Estimator", say: "Callable[[int, str], None]") -> None:
        self._values: list[float] = parameters.values
        self._kite = kite
        self._say = say
        self.mode: int = KITE_MODE_STANDBY
        self.stale: bool = False
        self.manual_steering: float = 0.0
        self._manual_silence_us: int = 0
        self._fresh_us: int = _NEVER  # for how long samples have been accepted without a gap
        self._station_heard: bool = False
        self._station_silence_us: int = 0
        self._station_silent: bool = False  # and what follows from it was done

    def armed(self) -> bool:
        """True in every mode but STANDBY."""
        return self.mode != KITE_MODE_STANDBY

    def arm(self, problem: str | None) -> str | None:
        """Arm into PARK; return None, or why not. Nothing happens when armed already.

        `problem` is what else speaks against it, or None: a curve that cannot be flown, a loop that is too slow.
        """
        if self.armed():
            return None
        reason = "no samples from the kite" if self._kite.is_stale() else problem
        if reason is None:
            self._enter(KITE_MODE_PARK, "armed")
        return reason

    def disarm(self) -> None:
        """Go to STANDBY."""
        if self.armed():
            self._enter(KITE_MODE_STANDBY, "disarmed")

    def recover(self) -> None:
        """Fly on in PARK after a reset in flight: armed, and neutral until samples have come for a while."""
        self.stale = True
        self._enter(KITE_MODE_PARK, "back after a reset", MAV_SEVERITY_CRITICAL)

    def command(self, mode: int, curve_problem: str | None) -> str | None:
        """Change to `mode` as an operator asked; return None, or why not. PARK and MANUAL are open to any armed kite.

        `curve_problem` is why the target curve cannot be flown, or None.
        """
        if not 0 <= mode < len(NAMES):
            return "no such mode"
        if mode == KITE_MODE_STANDBY:
            self.disarm()
            return None
        if not self.armed():
            return "arm first"
        if mode == KITE_MODE_TRACK and (self.stale or mode != self.mode):
            problem = "samples are stale" if self.stale else curve_problem
            if problem is not None:
                return problem
        if mode != self.mode:
            self._manual_silence_us = 0
            self.manual_steering = 0.0
            self._enter(mode, "")
        return None

    def hear_station(self) -> None:
        """A ground station's heartbeat arrived."""
        self._station_heard = True
        self.hear_operator()

    def hear_operator(self) -> None:
        """A sign of life arrived: an arm, disarm or mode command, a heartbeat, or MANUAL_CONTROL."""
        self._station_silence_us = 0
        self._station_silent = False

    def hear_manual(self, steering: float) -> None:
        """MANUAL_CONTROL arrived with `steering` in [-1, 1]."""
        self.manual_steering = steering
        self._manual_silence_us = 0
        self.hear_operator()

    def update(self, elapsed_us: int, missing: bool, fresh: bool) -> None:
        """Look once a tick at everything that may be missing; `elapsed_us` since the last look.

        `missing`: no accepted sample was fresh enough when this tick began. `fresh`: it has brought one.
        """
        silence_us = self._station_silence_us + elapsed_us
        self._station_silence_us = silence_us if silence_us < _FOREVER_US else _FOREVER_US
        fresh_us = self._fresh_us
        if missing or fresh_us == _NEVER:
            self._fresh_us = 0 if fresh else _NEVER
        else:
            fresh_us += elapsed_us
            self._fresh_us = fresh_us if fresh_us < _FOREVER_US else _FOREVER_US
        if self.mode == KITE_MODE_STANDBY:
            return
        if missing or self.stale:
            self._watch_samples(missing, fresh)
        values = self._values
        if self.mode == KITE_MODE_MANUAL:
            self._watch_pilot(elapsed_us, int(values[MANUAL_TIME] * 1e6))
        limit_s = values[GCS_LOST_TIME]
        if limit_s and self._station_heard:
            self._watch_station(int(limit_s * 1e6))
        else:
            self._station_silent = False
        if self.mode == KITE_MODE_TRACK and not self.stale:
            least_deg = values[PARK_ELEVATION]
            if least_deg != 0.0 and self._kite.elevation < radians(least_deg):
                self._park("too low")

    def _watch_samples(self, missing: bool, fresh: bool) -> None:
        if missing and not self.stale:
            self.stale = True
            what = "is the pilot's" if self.mode == KITE_MODE_MANUAL else "neutral"
            self._say(MAV_SEVERITY_CRITICAL, "samples stale: steering " + what)
        elif self.stale and fresh and self._fresh_us >= _FRESH_US:
            self.stale = False
            goes_on = self.mode != KITE_MODE_TRACK or self._values[RESUME_TRACK]
            self._enter(self.mode if goes_on else KITE_MODE_PARK, "samples fresh again")

    def _watch_pilot(self, elapsed_us: int, limit_us: int) -> None:
        self._manual_silence_us = min(self._manual_silence_us + elapsed_us, _FOREVER_US)
        if self._manual_silence_us > limit_us:
            self._park("no MANUAL_CONTROL")

    def _watch_station(self, limit_us: int) -> None:
        """A silence acts once; a station that is heard again begins another."""
        if not self._station_silent and self._station_silence_us > limit_us:
            self._station_silent = True
            self._park("ground station silent")

    def _park(self, why: str) -> None:
        self._enter(KITE_MODE_PARK, why, MAV_SEVERITY_WARNING)

    def _enter(self, mode: int, why: str, severity: int = MAV_SEVERITY_INFO) -> None:
        self.mode = mode
        if mode == KITE_MODE_STANDBY:
            self.stale = False
        self._say(severity, why + ": " + NAMES[mode] if why else "mode " + NAMES[mode])
