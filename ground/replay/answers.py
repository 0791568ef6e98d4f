"""Answers of a replay: parameters, recorded messages, the time; everything else is refused at once.

A replay accepts neither commands nor values. It says so, as silence would leave a ground station waiting.
"""

import struct
from bisect import bisect_right
from collections.abc import Callable
from typing import Any

from ground.link.framing import Message, Received
from ground.logs.parameters import LoggedParameters
from ground.logs.reader import Logged, MessageLog
from protocol import dialect
from protocol.frame import Address

_Answer = Message | bytes
_MISSION_REQUEST_LIST, _FILE_TRANSFER_PROTOCOL = 43, 110
_FTP_REPLY = struct.Struct("<HBBBBBxI")  # sequence, session, operation, size, operation asked, burst complete, offset
_FTP_TERMINATE, _FTP_RESET, _FTP_ACK, _FTP_NAK, _FTP_NO_FILE = 1, 2, 128, 129, 10
_NO_PARAMETERS = b"replay: this log holds no parameters"
_NO_COMMANDS = b"replay: a flight of the past takes no command"


class ReplayAnswers:
    """Answers requests to one vehicle of `log`, whose recorded parameters are `parameters`."""

    def __init__(self, log: MessageLog, vehicle: Address, parameters: LoggedParameters) -> None:
        self.vehicle = vehicle
        self._parameters = parameters
        self._packer = dialect.MAVLink(None, vehicle.system, vehicle.component)
        self._entries: dict[int, list[Logged]] = {}
        for entry in log.of(vehicle):
            self._entries.setdefault(entry.header.message, []).append(entry)
        self._clock = [(entry.time_s, entry.message.tc1) for entry in log.of(vehicle)
                       if isinstance(entry.message, dialect.MAVLink_timesync_message) and entry.message.tc1]
        self._handlers: dict[int, Callable[[Any, Address, float], list[_Answer]]] = {
            dialect.MAVLINK_MSG_ID_PARAM_REQUEST_LIST: self._list,
            dialect.MAVLINK_MSG_ID_PARAM_REQUEST_READ: self._read,
            dialect.MAVLINK_MSG_ID_PARAM_SET: self._refuse_value,
            dialect.MAVLINK_MSG_ID_COMMAND_LONG: self._command,
            dialect.MAVLINK_MSG_ID_TIMESYNC: self._time,
            dialect.MAVLINK_MSG_ID_PING: self._ping,
            _MISSION_REQUEST_LIST: self._no_mission,
            _FILE_TRANSFER_PROTOCOL: self._no_file,
        }

    def answer(self, request: Received, position_s: float) -> list[bytes]:
        """Frames that answer `request` at `position_s` [s] in the log; none if it is not for this vehicle.

        Their sequence numbers are yet to be set.
        """
        message = request.message
        handler = self._handlers.get(request.header.message)
        if handler is None or request.header.sender.system == self.vehicle.system:
            return []
        if isinstance(message, dialect.MAVLink_unknown):
            message = _decode_with_the_standard(request.frame)
        system, component = getattr(message, "target_system", 0), getattr(message, "target_component", 0)
        if message is None or system not in (0, self.vehicle.system) or component not in (0, self.vehicle.component):
            return []
        answers = handler(message, request.header.sender, position_s)
        return [answer if isinstance(answer, bytes) else answer.pack(self._packer) for answer in answers]

    def rewritten(self, entry: Logged) -> Logged:
        """This entry of the log; a PARAM_VALUE gets the index and count that the answers give.

        If the log has only some of the vehicle's parameters, it presents those as all: otherwise a ground station would
        request the others for ever.
        """
        message = entry.message
        if self._parameters.complete or not isinstance(message, dialect.MAVLink_param_value_message):
            return entry
        self._packer.seq = entry.header.sequence
        frame = self._value(message.param_id, message.param_value).pack(self._packer)
        return entry._replace(frame=frame)

    def _value(self, name: str, value: float) -> Message:
        total = self._parameters.total if self._parameters.complete else len(self._parameters.names)
        return dialect.MAVLink_param_value_message(
            name.encode("ascii"), value, dialect.MAV_PARAM_TYPE_REAL32, total, self._parameters.names.index(name))

    def _list(self, asked: Message, asker: Address, position_s: float) -> list[_Answer]:
        values = self._parameters.values(position_s)
        return [self._value(name, value) for name, value in values.items()] or [_say(_NO_PARAMETERS)]

    def _read(self, asked: dialect.MAVLink_param_request_read_message, asker: Address, position_s: float
              ) -> list[_Answer]:
        names, place = self._parameters.names, asked.param_index
        wanted = [asked.param_id] if place < 0 else names[place : place + 1]
        if wanted and wanted[0] in names:
            return [self._value(wanted[0], self._parameters.value(wanted[0], position_s))]
        return [_refuse(asker, asked.param_id, place, dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST)]

    def _refuse_value(self, asked: dialect.MAVLink_param_set_message, asker: Address, position_s: float
                      ) -> list[_Answer]:
        name = asked.param_id
        if name not in self._parameters.names:
            return [_refuse(asker, name, -1, dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST)]
        return [_refuse(asker, name, -1, dialect.MAV_PARAM_ERROR_READ_ONLY),
                self._value(name, self._parameters.value(name, position_s))]

    def _command(self, asked: dialect.MAVLink_command_long_message, asker: Address, position_s: float
                 ) -> list[_Answer]:
        if asked.command != dialect.MAV_CMD_REQUEST_MESSAGE:
            return [_acknowledge(asked, asker, dialect.MAV_RESULT_DENIED), _say(_NO_COMMANDS)]
        entries = self._entries.get(int(asked.param1) if 0.0 <= asked.param1 < 1 << 24 else -1)
        if not entries:
            return [_acknowledge(asked, asker, dialect.MAV_RESULT_DENIED)]
        at = bisect_right(entries, position_s, key=lambda entry: entry.time_s) - 1
        return [_acknowledge(asked, asker, dialect.MAV_RESULT_ACCEPTED), entries[max(at, 0)].frame]

    def _time(self, asked: dialect.MAVLink_timesync_message, asker: Address, position_s: float) -> list[_Answer]:
        """The vehicle's clock at this point of the flight, or the log's time if the log does not have it."""
        if asked.tc1:
            return []
        at = bisect_right(self._clock, (position_s, float("inf"))) - 1
        time_s, clock_ns = self._clock[max(at, 0)] if self._clock else (0.0, 0)
        clock_ns += round((position_s - time_s) * 1e9)
        return [dialect.MAVLink_timesync_message(max(clock_ns, 1), asked.ts1)]

    def _ping(self, asked: dialect.MAVLink_ping_message, asker: Address, position_s: float) -> list[_Answer]:
        if asked.target_system or asked.target_component:
            return []
        return [dialect.MAVLink_ping_message(asked.time_usec, asked.seq, *asker)]

    def _no_mission(self, asked: Any, asker: Address, position_s: float) -> list[_Answer]:
        from pymavlink.dialects.v20 import common  # noqa: PLC0415  (large)

        count = common.MAVLink_mission_count_message(*asker, 0, asked.mission_type)
        return [bytes(count.pack(common.MAVLink(None, *self.vehicle)))]

    def _no_file(self, asked: Any, asker: Address, position_s: float) -> list[_Answer]:
        """Sessions end without error, and there are no files: a ground station then requests single parameters."""
        from pymavlink.dialects.v20 import common  # noqa: PLC0415

        sequence, session, operation, _, _, _, _ = _FTP_REPLY.unpack_from(bytes(asked.payload))
        if operation >= _FTP_ACK:
            return []
        ends = operation in (_FTP_TERMINATE, _FTP_RESET)
        head = _FTP_REPLY.pack((sequence + 1) % 65536, session, _FTP_ACK if ends else _FTP_NAK, 0 if ends else 1,
                               operation, 0, 0)
        content = (head + (b"" if ends else bytes([_FTP_NO_FILE]))).ljust(len(asked.payload), b"\0")
        reply = common.MAVLink_file_transfer_protocol_message(0, *asker, content)
        return [bytes(reply.pack(common.MAVLink(None, *self.vehicle)))]


def _decode_with_the_standard(frame: bytes) -> Any:
    """A message of common.xml that the kite's dialect lacks; None if it is damaged."""
    from pymavlink.dialects.v20 import common  # noqa: PLC0415

    try:
        return common.MAVLink(None).decode(bytearray(frame))
    except common.MAVError:
        return None


def _refuse(asker: Address, name: str, index: int, error: int) -> Message:
    return dialect.MAVLink_param_error_message(*asker, name.encode("ascii", "replace"), index, error)


def _acknowledge(asked: dialect.MAVLink_command_long_message, asker: Address, result: int) -> Message:
    return dialect.MAVLink_command_ack_message(asked.command, result, 0, 0, *asker)


def _say(text: bytes) -> Message:
    return dialect.MAVLink_statustext_message(dialect.MAV_SEVERITY_WARNING, text)
