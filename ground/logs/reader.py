"""Reads a tlog: every message with its sender and time."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from ground.errors import UsageError
from ground.link.connection import KITE_COMPONENT, is_of
from ground.link.framing import Message, make_printable
from kite_analysis.flights.tlog import read_tlog
from protocol import dialect
from protocol.frame import Address, Header, read_header

Heartbeat = dialect.MAVLink_heartbeat_message
_LONGEST_PAUSE_US = 86_400_000_000  # after a day without any message, the clock was set
_END_OF_DATES_US = 253_402_300_800_000_000  # the year 10000


class Logged(NamedTuple):
    """One message of a log; `time_s` [s] counts from the log's first frame and never decreases."""

    time_s: float
    header: Header
    message: Message
    frame: bytes

    @property
    def sender(self) -> Address:
        """The sender."""
        return self.header.sender


class MessageLog:
    """The contents of a tlog. `remarks` are lines for the user about what cannot be used.

    `start_us` is the time of its first frame, in microseconds since 1970 (UTC).
    """

    def __init__(self, path: str | Path, messages: list[Logged], start_us: int, remarks: list[str]) -> None:
        self.path = Path(path)
        self.messages = messages
        self.start_us = start_us
        self.remarks = remarks
        self.vehicles = _vehicles(messages)
        self.stations = {entry.sender for entry in messages
                         if isinstance(entry.message, Heartbeat) and entry.message.type == dialect.MAV_TYPE_GCS}

    @property
    def duration_s(self) -> float:
        """Time from the first frame to the last [s]."""
        return self.messages[-1].time_s

    def vehicle(self, system: int | None = None) -> Address:
        """The only autopilot, or the one with this system id. Raises UsageError if that is none or several."""
        found = [address for address in self.vehicles if system in (None, address.system)]
        if len(found) == 1:
            return found[0]
        heard = ", ".join(str(address.system) for address in self.vehicles) or "none"
        if not self.vehicles:
            raise UsageError(f"{self.path}: no autopilot in this log")
        advice = "choose one with --system" if system is None else "check --system"
        raise UsageError(f"{self.path}: holds the autopilots of systems {heard}: {advice}")

    def of(self, vehicle: Address) -> Iterator[Logged]:
        """The messages of one vehicle."""
        return (entry for entry in self.messages if is_of(entry.sender, vehicle))


def read_message_log(path: str | Path) -> MessageLog:
    """Read the whole tlog at `path`.

    Raises:
        UsageError: it cannot be read, is not a tlog, or is empty.
    """
    messages: list[Logged] = []
    decoder = dialect.MAVLink(None)
    clock = _RecorderClock()
    broken, remarks = 0, []
    try:
        for stamp_us, frame in read_tlog(path):
            time_s = clock.elapsed_s(stamp_us)
            try:
                message = decoder.decode(bytearray(frame))
            except dialect.MAVError:
                broken += 1
                continue
            make_printable(message)
            messages.append(Logged(time_s, read_header(frame), message, frame))
    except OSError as error:
        raise UsageError(f"{path}: cannot read: {error.strerror}") from None
    except ValueError as error:
        if not messages:
            raise UsageError(f"{error}") from None
        remarks.append(f"{error}; using the part before it")
    if not messages:
        raise UsageError(f"{path}: holds no messages")
    return MessageLog(path, messages, clock.start_us, remarks + clock.remarks + _left_out(messages, broken))


class _RecorderClock:
    """The recorder's stamps as elapsed time, which stands still where its clock was set or a stamp is damaged."""

    def __init__(self) -> None:
        self._last_us: int | None = None
        self._elapsed_us = 0
        self._starts: Counter[int] = Counter()  # start of the log, by each stamp: the same until the clock jumps
        self._jumps_us: list[int] = []

    def elapsed_s(self, stamp_us: int) -> float:
        """Time [s] from the first stamp to this one; to be called for each in turn."""
        step_us = 0 if self._last_us is None else stamp_us - self._last_us
        self._last_us = stamp_us
        if 0 <= step_us <= _LONGEST_PAUSE_US:
            self._elapsed_us += step_us
        else:
            self._jumps_us.append(step_us)
        self._starts[stamp_us - self._elapsed_us] += 1
        return self._elapsed_us * 1e-6

    @property
    def start_us(self) -> int:
        """Time of the first frame, by most of the stamps, in us since 1970 (UTC); 0 if that is not a date."""
        start_us = max(self._starts, key=self._starts.__getitem__, default=0)
        return start_us if 0 <= start_us < _END_OF_DATES_US else 0

    @property
    def remarks(self) -> list[str]:
        """A line if the stamps jump."""
        if not self._jumps_us:
            return []
        largest_s = max(self._jumps_us, key=abs) * 1e-6
        return [f"the recorder's clock jumps {_times(len(self._jumps_us))}, by up to {largest_s:+.3g} s: "
                "jumps removed, all messages used"]


def _left_out(messages: list[Logged], broken: int) -> list[str]:
    unknown = Counter(entry.header.message for entry in messages if isinstance(entry.message, dialect.MAVLink_unknown))
    remarks = []
    if unknown:
        ids = ", ".join(str(number) for number in sorted(unknown))
        remarks.append(f"{unknown.total()} messages are of unknown types (ids {ids})")
    if broken:
        remarks.append(f"{broken} frames are broken (wrong checksum)")
    return remarks


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _vehicles(messages: list[Logged]) -> list[Address]:
    """The autopilots, by their heartbeats; without any, as in a truncated log, the senders of KITE_STATE."""
    beats = [entry.sender for entry in messages if isinstance(entry.message, Heartbeat)
             and entry.message.type != dialect.MAV_TYPE_GCS
             and entry.message.autopilot != dialect.MAV_AUTOPILOT_INVALID]
    states = [_autopilot_of(entry.sender) for entry in messages
              if isinstance(entry.message, dialect.MAVLink_kite_state_message)]
    return list(dict.fromkeys(beats or states))


def _autopilot_of(sender: Address) -> Address:
    """The autopilot whose state `sender` reports."""
    return Address(sender.system, dialect.MAV_COMP_ID_AUTOPILOT1) if sender.component == KITE_COMPONENT else sender
