"""docs/modes.md, "What the firmware puts out", as a table that rows of a flight are held against."""

import math
from typing import NamedTuple

from firmware_bench import MANUAL, PARK, STANDBY, TRACK

from protocol import dialect

MODE_NAMES = {STANDBY: "STANDBY", MANUAL: "MANUAL", PARK: "PARK", TRACK: "TRACK"}
CUSTOM, ARMED = dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, dialect.MAV_MODE_FLAG_SAFETY_ARMED
ACTIVE, CRITICAL, AT_REST = dialect.MAV_STATE_ACTIVE, dialect.MAV_STATE_CRITICAL, dialect.MAV_STATE_STANDBY
STALE_TEXTS = {
    MANUAL: "samples stale: steering is the pilot's",
    PARK: "samples stale: steering neutral",
    TRACK: "samples stale: steering neutral",
}
ROUNDING = 1e-5  # of what crosses the wire as float32


class DivergenceError(AssertionError):
    """The firmware did not do what docs/modes.md says; `kind` is the rule in a few words."""

    def __init__(self, kind: str, details: str = ""):
        super().__init__(f"{kind}: {details}" if details else kind)
        self.kind = kind


class Row(NamedTuple):
    """A row of the table: the flight as it may be at some moment of a tick. `sticks` is what the pilot asks for."""

    mode: int
    stale: bool
    sticks: float

    @property
    def by_law(self) -> bool:
        """The control law steers."""
        return self.mode in (PARK, TRACK) and not self.stale

    @property
    def heartbeat(self) -> tuple[int, int, int]:
        """(custom_mode, base_mode, system_status)."""
        if self.mode == STANDBY:
            return STANDBY, CUSTOM, AT_REST
        return self.mode, CUSTOM | ARMED, CRITICAL if self.stale else ACTIVE


class Limits(NamedTuple):
    """STEER_MAX, and how far STEER_RATE lets steering go in a tick (0: any distance)."""

    most: float
    step: float


def allows(row: Row, steering: float, previous: float, limits: Limits) -> bool:
    """Whether a tick in this row may put out `steering`, after the `previous` tick's."""
    if row.mode == MANUAL:
        return abs(steering - slewed(max(-limits.most, min(limits.most, row.sticks)), previous, limits)) < ROUNDING
    if not row.by_law:
        return steering == 0.0
    return abs(steering - slewed(steering, previous, limits)) < ROUNDING  # what the law wants is not told here


def slewed(wanted: float, previous: float, limits: Limits) -> float:
    """`wanted` as far as STEER_RATE lets it be reached, and never outside STEER_MAX."""
    previous = max(-limits.most, min(limits.most, previous))
    if limits.step:
        wanted = max(previous - limits.step, min(previous + limits.step, wanted))
    return max(-limits.most, min(limits.most, wanted))


def check_steering(rows: list[Row], steering: float, previous: float, limits: Limits) -> None:
    """Finite and within limits whatever the row says, and what one of the tick's rows says."""
    if not math.isfinite(steering):
        raise DivergenceError("steering is not finite", f"{steering} in {rows}")
    if abs(steering) > limits.most + 1e-7:
        raise DivergenceError("steering beyond STEER_MAX", f"{steering} beyond {limits.most} in {rows}")
    if not any(allows(row, steering, previous, limits) for row in rows):
        last = rows[-1]
        about = "disarmed" if last.mode == STANDBY else f"{MODE_NAMES[last.mode]}, {'stale' if last.stale else 'fresh'}"
        raise DivergenceError(f"steering while {about}", f"{previous} -> {steering} with {limits} in {rows}")
