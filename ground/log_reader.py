"""A recorded flight, read back from its tlog: every message, who sent it and when it came."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from analysis.tlog import read_tlog
from ground.connection import KITE_COMPONENT, Address, is_of
from ground.errors import UsageError
from ground.framing import Message
from protocol import dialect

Heartbeat = dialect.MAVLink_heartbeat_message
_MARKER_2 = dialect.PROTOCOL_MARKER_V2


class Logged(NamedTuple):
    """One message of a log; `time_s` [s] counts from the log's first frame and never goes back."""

    time_s: float
    sender: Address
    sequence: int
    message: Message
    frame: bytes


class FlightLog:
    """What a tlog holds. `remarks` are lines for the user on what of it cannot be used.

    `start_us` is when its first frame came, in microseconds since 1970 (UTC).
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
        """Whose flight this is: the only autopilot, or the one with this system id. Raises UsageError."""
        found = [address for address in self.vehicles if system in (None, address.system)]
        if len(found) == 1:
            return found[0]
        heard = ", ".join(str(address.system) for address in self.vehicles) or "none"
        if not self.vehicles:
            raise UsageError(f"{self.path}: no autopilot is heard in this log")
        advice = "choose one with --system" if system is None else "check --system"
        raise UsageError(f"{self.path}: holds the autopilots of systems {heard}: {advice}")

    def of(self, vehicle: Address) -> Iterator[Logged]:
        """The messages of one vehicle."""
        return (entry for entry in self.messages if is_of(entry.sender, vehicle))


def read_flight_log(path: str | Path) -> FlightLog:
    """Read the tlog at `path` whole.

    Raises:
        UsageError: it cannot be read, is no tlog, or holds nothing.
    """
    messages: list[Logged] = []
    decoder = dialect.MAVLink(None)
    start_us = last_us = set_back_us = broken = 0
    remarks = []
    try:
        for stamp_us, frame in read_tlog(path):
            start_us = start_us or stamp_us
            set_back_us += max(last_us - stamp_us, 0)  # where the clock was set back, time stands still instead
            last_us = stamp_us
            try:
                message = decoder.decode(bytearray(frame))
            except dialect.MAVError:
                broken += 1
                continue
            time_s = (stamp_us + set_back_us - start_us) * 1e-6
            sequence = frame[4 if frame[0] == _MARKER_2 else 2]
            messages.append(Logged(time_s, sender_of(frame), sequence, message, frame))
    except OSError as error:
        raise UsageError(f"{path}: cannot read: {error.strerror}") from None
    except ValueError as error:
        if not messages:
            raise UsageError(f"{error}") from None
        remarks.append(f"{error}; what comes before is used")
    if not messages:
        raise UsageError(f"{path}: holds no message")
    return FlightLog(path, messages, start_us, remarks + _left_out(messages, broken))


def frame_id(frame: bytes) -> int:
    """The message id in a frame."""
    return int.from_bytes(frame[7:10], "little") if frame[0] == _MARKER_2 else frame[5]


def sender_of(frame: bytes) -> Address:
    """Who sent a frame."""
    at = 5 if frame[0] == _MARKER_2 else 3
    return Address(frame[at], frame[at + 1])


def payload(frame: bytes, length: int) -> bytes:
    """The frame's payload, with the zeros that MAVLink 2 leaves out, `length` bytes in all."""
    start = 10 if frame[0] == _MARKER_2 else 6
    return frame[start : start + frame[1]].ljust(length, b"\0")[:length]


def _left_out(messages: list[Logged], broken: int) -> list[str]:
    unknown = Counter(frame_id(entry.frame) for entry in messages if isinstance(entry.message, dialect.MAVLink_unknown))
    remarks = []
    if unknown:
        ids = ", ".join(str(number) for number in sorted(unknown))
        remarks.append(f"{unknown.total()} messages are of kinds not known here (ids {ids})")
    if broken:
        remarks.append(f"{broken} frames are broken: their checksum is wrong")
    return remarks


def _vehicles(messages: list[Logged]) -> list[Address]:
    """The autopilots, by their heartbeats; else whoever sends a kite's state, as in a log cut short."""
    beats = [entry.sender for entry in messages if isinstance(entry.message, Heartbeat)
             and entry.message.type != dialect.MAV_TYPE_GCS
             and entry.message.autopilot != dialect.MAV_AUTOPILOT_INVALID]
    states = [_autopilot_of(entry.sender) for entry in messages
              if isinstance(entry.message, dialect.MAVLink_kite_state_message)]
    return list(dict.fromkeys(beats or states))


def _autopilot_of(sender: Address) -> Address:
    """Whose state `sender` tells."""
    return Address(sender.system, dialect.MAV_COMP_ID_AUTOPILOT1) if sender.component == KITE_COMPONENT else sender
