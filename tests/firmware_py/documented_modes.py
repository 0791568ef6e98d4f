"""docs/modes.md as an oracle over a whole flight: modes, stale samples, fail-safes, what is put out and told.

Written from that page, not from the firmware. Times are in microseconds; `now` counts what has elapsed and never wraps.
"""

import math
from typing import Any, NamedTuple

from documented_commands import Commands, Frame
from documented_output import MODE_NAMES, STALE_TEXTS, DivergenceError, Limits, Row, check_steering
from documented_samples import SECOND, WRAP, DocumentedSamples
from firmware_bench import MANUAL, PARK, STANDBY, TRACK

from protocol import dialect
from protocol.parameter_table import load_parameters
from sim_bridge.equipment.sensors import Sample

TEXT_TICKS = 12  # texts go out one a tick
HEARTBEAT_US = 3 * SECOND  # once a second; a clock that has jumped, which counts as a second, may cost two more
NEUTRAL_TICKS = 25  # a control law that wants nothing at all for so long does not steer,
UPWARDS = 0.01  # unless the kite is to park and flies straight up already [rad]


class Seen(NamedTuple):
    """What a tick put out: `messages` on the wire, and the firmware's own word on mode, stale and parameters."""

    steering: float
    messages: list[Any]
    mode: int
    stale: bool
    parameters: dict[str, float]

    def of_kind(self, kind: str) -> list[Any]:
        """The messages of a type."""
        return [message for message in self.messages if message.get_type() == kind]


class Owed(NamedTuple):
    """A text that must come, in one of several wordings, while there are `ticks` left."""

    wordings: frozenset[str]
    ticks: int


class Documented:
    """The flight that docs/modes.md describes; `tick` raises DivergenceError where the firmware flies another one."""

    def __init__(self, parameters: dict[str, float] | None = None):
        self.parameters = parameters or {name: entry.default for name, entry in load_parameters().items()}
        self.samples = DocumentedSamples()
        self.commands = Commands(self)
        self.mode = STANDBY
        self.stale = True
        self.sticks = 0.0
        self.now = 0
        self.steering = 0.0
        self._clock: int | None = None
        self._manual_us = 0  # when the pilot was heard last, or MANUAL entered
        self._station_heard = False
        self._station_us = 0
        self._silence_told = False
        self._without_heartbeat_us = 0
        self._neutral_ticks = 0
        self._owed: list[Owed] = []

    def after_watchdog_reset(self) -> "Documented":
        """The flight after a reset now: armed as before, in PARK, stale, with the parameters that were set."""
        again = Documented(dict(self.parameters))
        if self.armed:
            again.mode = PARK
            again.owe("back after a reset: PARK")
        return again

    def is_close_call(self, clock: int, sample: Sample) -> bool:
        """A sample with which rounding would decide what the tick at `clock` does."""
        return self.samples.is_close_call(self.now + self._elapsed(clock), sample)

    def _elapsed(self, clock: int) -> int:
        return 0 if self._clock is None else (clock - self._clock) % WRAP

    @property
    def armed(self) -> bool:
        """In every mode but STANDBY."""
        return self.mode != STANDBY

    def tick(self, clock: int, sample: Sample | None, frames: list[Frame], seen: Seen) -> None:
        """Hold a tick at `clock` [us, wrapped] against the page: `sample` and `frames` arrived, `seen` came out."""
        elapsed = self._elapsed(clock)
        self.now += elapsed
        self._clock = clock
        limits = self._limits()
        self._watch_samples(sample)
        self._fail_safes()
        rows = [self._row()]
        for frame in frames:
            self._hear(frame)
            rows.append(self._row())
        self.commands.settle(seen)
        rows.append(self._row())
        self._check_mode(seen)
        check_steering(rows, seen.steering, self.steering, limits)
        self.steering = seen.steering
        self._check_law_steers(rows[-1])
        self._check_telemetry(rows, elapsed, seen)
        self._check_texts([text.text for text in seen.of_kind("STATUSTEXT")])

    def enter(self, mode: int) -> None:
        """Go to `mode`, as was commanded; MANUAL begins neutral, and the pilot's silence counts from there."""
        if mode == MANUAL != self.mode:
            self.sticks = 0.0
            self._manual_us = self.now
        self.mode = mode

    def hear_operator(self) -> None:
        """An arm, disarm or mode command, or MANUAL_CONTROL: the station is not silent."""
        self._station_us = self.now
        self._silence_told = False

    def _row(self) -> Row:
        return Row(self.mode, self.stale, self.sticks)

    def _limits(self) -> Limits:
        rate = self.parameters["STEER_RATE"]
        return Limits(self.parameters["STEER_MAX"], rate / self.parameters["LOOP_HZ"])

    def _hear(self, frame: Frame) -> None:
        message = frame.message
        kind = message.get_type()
        if kind == "HEARTBEAT":
            self._station_heard = True
            self.hear_operator()
        elif kind == "MANUAL_CONTROL":
            self.hear_operator()
            if self.mode == MANUAL:
                self.sticks = message.y / 1000.0
                self._manual_us = self.now
        else:
            self.commands.hear(frame)

    # When samples are fresh

    def _watch_samples(self, sample: Sample | None) -> None:
        samples = self.samples
        samples.stale_time = math.floor(self.parameters["STALE_TIME"] * SECOND)
        samples.jump_rate = math.radians(self.parameters["JUMP_RATE"])
        old = samples.is_old(self.now)
        samples.take(self.now, sample)
        if old:
            if self.armed and not self.stale:
                self.owe(STALE_TEXTS[self.mode])
            self.stale = True
        elif self.stale and samples.are_fresh_again():
            self.stale = False
            if self.armed:
                self._go_on()

    def _go_on(self) -> None:
        if self.mode == TRACK and not self.parameters["RESUME_TRACK"]:
            self.mode = PARK
        self.owe(f"samples fresh again: {MODE_NAMES[self.mode]}")

    # Fail-safes

    def _fail_safes(self) -> None:
        if not self.armed:
            return
        if self.mode == MANUAL and self._longer(self._manual_us, "MANUAL_TIME"):
            self._park("no MANUAL_CONTROL: PARK")
        silent = self._station_heard and self.parameters["GCS_LOST_TIME"] and self._longer(
            self._station_us, "GCS_LOST_TIME")
        if silent and not self._silence_told:
            self._silence_told = True
            if self.mode != PARK:
                self._park("ground station silent: PARK")
        if self.mode == TRACK and not self.stale and self._too_low():
            self._park("too low: PARK")

    def _park(self, text: str) -> None:
        self.mode = PARK
        self.owe(text)

    def _longer(self, since: int, name: str) -> bool:
        return self.now - since > self.parameters[name] * SECOND

    def _too_low(self) -> bool:
        least = self.parameters["PARK_ELEVATION"]
        return bool(least) and self.samples.last is not None and self.samples.last.elevation < math.radians(least)

    # What is put out and told

    def _check_mode(self, seen: Seen) -> None:
        if seen.mode != self.mode:
            raise DivergenceError(f"mode {MODE_NAMES[seen.mode]} where the page says {MODE_NAMES[self.mode]}",
                                  self.commands.story())
        if self.armed and seen.stale != self.stale:
            words = ("stale", "fresh") if self.stale else ("fresh", "stale")
            raise DivergenceError("{1} where the page says {0}".format(*words),
                                  f"last accepted {self.samples.last}, now {self.now}")

    def _check_law_steers(self, row: Row) -> None:
        parameters = self.parameters
        last = self.samples.last
        works = parameters["INNER_P"] >= 0.25 and parameters["GAIN_TAU"] == 0.0
        if row.mode == PARK and last and abs(last.course) < UPWARDS:
            works = False
        self._neutral_ticks = self._neutral_ticks + 1 if row.by_law and works and self.steering == 0.0 else 0
        if self._neutral_ticks > NEUTRAL_TICKS:
            raise DivergenceError("the control law does not steer", str(row))

    def _check_telemetry(self, rows: list[Row], elapsed: int, seen: Seen) -> None:
        beats = seen.of_kind("HEARTBEAT")
        for beat in beats:
            told = (beat.custom_mode, beat.base_mode, beat.system_status)
            if told not in [row.heartbeat for row in rows]:
                raise DivergenceError("heartbeat tells another state", f"{told} in {rows}")
        self._without_heartbeat_us = 0 if beats else self._without_heartbeat_us + min(elapsed, SECOND)
        if self._without_heartbeat_us > HEARTBEAT_US:
            raise DivergenceError("no heartbeat")
        for state in seen.of_kind("KITE_STATE"):
            is_stale = bool(state.status & dialect.KITE_STATUS_STALE)
            if state.mode != self.mode or (self.armed and is_stale != self.stale):
                raise DivergenceError("KITE_STATE tells another state", f"{state} in {rows[-1]}")
            last = self.samples.last
            if last and state.sample_time_us != last.stamp:
                raise DivergenceError("another sample is steered by", f"{state.sample_time_us}, not {last}")

    def owe(self, *wordings: str) -> None:
        """A text in one of these wordings must come."""
        self._owed.append(Owed(frozenset(wordings), TEXT_TICKS))

    def _check_texts(self, told: list[str]) -> None:
        for text in told:
            for owed in self._owed:
                if text in owed.wordings:
                    self._owed.remove(owed)
                    break
        self._owed = [owed._replace(ticks=owed.ticks - 1) for owed in self._owed]
        for owed in self._owed:
            if not owed.ticks and self.commands.recent(TEXT_TICKS) < 4:  # a crowd of texts may push one out
                raise DivergenceError("not told: " + " or ".join(sorted(owed.wordings)))
        self._owed = [owed for owed in self._owed if owed.ticks]
