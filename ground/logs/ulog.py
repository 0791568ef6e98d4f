"""A log as ULog: every message as sent, the parameters, and the texts."""

from pathlib import Path

from ground.link.connection import is_of
from ground.logs.parameters import LoggedParameters
from ground.logs.reader import Logged, MessageLog
from ground.logs.ulog_writer import UlogWriter
from protocol import dialect
from protocol.frame import Address, payload

_TYPES = {"b": "int8_t", "B": "uint8_t", "h": "int16_t", "H": "uint16_t", "i": "int32_t", "I": "uint32_t",
          "q": "int64_t", "Q": "uint64_t", "f": "float", "d": "double", "c": "char"}
_SENDER = [("uint8_t", "source_system"), ("uint8_t", "source_component")]


def write_ulog(log: MessageLog, vehicle: Address, path: Path) -> int:
    """Write `log` to `path`, with the parameters and texts of `vehicle`; return the number of messages.

    Times are microseconds since the log's first frame. A MAVLink message's topic has its name in lower case and its
    fields in wire order; several senders of a message are instances of its topic, the vehicle first.

    Raises:
        OSError: the file cannot be written.
    """
    parameters = LoggedParameters(log, vehicle)
    entries = [entry for entry in log.messages if not isinstance(entry.message, dialect.MAVLink_unknown)]
    changes = parameters.changes()
    with path.open("wb") as file:
        writer = UlogWriter(file, 0)
        _define(writer, log, parameters, entries)
        topics = _subscribe(writer, entries, vehicle)
        for entry in entries:
            while changes and changes[0].time_s <= entry.time_s:
                change = changes.pop(0)
                writer.parameter(change.name, change.value)
            _write(writer, topics[entry.message.get_type(), entry.sender], entry, vehicle)
    return len(entries)


def _define(writer: UlogWriter, log: MessageLog, parameters: LoggedParameters, entries: list[Logged]) -> None:
    writer.information("sys_name", "kitepilot")
    writer.information("log_start_utc_us", log.start_us)
    for kind in {type(entry.message): None for entry in entries}:
        writer.format(kind.msgname.lower(), _SENDER + _fields(kind))
    for name in parameters.names:
        writer.parameter(name, parameters.value(name, 0.0))


def _fields(kind: type[dialect.MAVLink_message]) -> list[tuple[str, str]]:
    """Type and name of a message's fields, in wire order."""
    layout = bytes(kind.native_format).decode("ascii").removeprefix("<")
    return [(f"{_TYPES[code]}[{count}]" if count else _TYPES[code], name)
            for code, count, name in zip(layout, kind.array_lengths, kind.ordered_fieldnames, strict=True)]


def _subscribe(writer: UlogWriter, entries: list[Logged], vehicle: Address) -> dict[tuple[str, Address], int]:
    """The topic's number for each message and sender."""
    found = dict.fromkeys((entry.message.get_type(), entry.sender) for entry in entries)
    instances: dict[str, int] = {}
    numbers = {}
    for name, sender in sorted(found, key=lambda topic: not is_of(topic[1], vehicle)):
        instance = instances.get(name, 0)
        instances[name] = instance + 1
        numbers[name, sender] = writer.subscribe(name.lower(), instance)
    return numbers


def _write(writer: UlogWriter, number: int, entry: Logged, vehicle: Address) -> None:
    time_us = round(entry.time_s * 1e6)
    message = entry.message
    writer.data(number, time_us, bytes(entry.sender) + payload(entry.frame, message.unpacker.size))
    if isinstance(message, dialect.MAVLink_statustext_message) and entry.sender == vehicle:
        writer.text(message.severity, time_us, message.text)
