"""The bridge's codec (pymavlink's), and the messages reserved for the control path."""

from typing import Any

from protocol import dialect
from protocol.frame import MARKER_2, message_id
from protocol.messages import BY_ID

CONTROL_ONLY = frozenset(
    (dialect.MAVLINK_MSG_ID_KITE_TICK, dialect.MAVLINK_MSG_ID_KITE_TICK_END, dialect.MAVLINK_MSG_ID_KITE_SENSORS))
BRIDGE_SYSTEM = 255
BRIDGE_COMPONENT = 255
DATAGRAM = 1400
STEERING_BYTES = 32  # a HIL_ACTUATOR_CONTROLS frame

Message = tuple[int, tuple[Any, ...]]  # id, and values in wire order


class BridgeCodec:
    """Packs and parses frames with the generated dialect, which is not the firmware's codec."""

    def __init__(self) -> None:
        self._mav = dialect.MAVLink(None, srcSystem=BRIDGE_SYSTEM, srcComponent=BRIDGE_COMPONENT)
        self._mav.robust_parsing = True

    def encode(self, message: int, values: tuple[Any, ...]) -> bytes:
        """A frame of `message`, whose `values` are in wire order."""
        kind = dialect.mavlink_map[message]
        return self.encode_message(kind(**dict(zip(kind.ordered_fieldnames, values, strict=True))))

    def encode_message(self, message: dialect.MAVLink_message) -> bytes:
        """A frame of a pymavlink message."""
        frame = message.pack(self._mav)
        self._mav.seq = (self._mav.seq + 1) % 256
        return frame

    def decode(self, data: bytes) -> list[dialect.MAVLink_message]:
        """The good messages in `data`."""
        messages = self._mav.parse_buffer(data) or []
        return [message for message in messages if message.get_type() != "BAD_DATA"]


def wire_values(message: dialect.MAVLink_message) -> tuple[Any, ...]:
    """Values of a message without arrays of numbers, in wire order; text as bytes. With names, if there are any."""
    fields = (getattr(message, name) for name in message.ordered_fieldnames)
    values = tuple(value.encode() if isinstance(value, str) else value for value in fields)
    return with_names(message.get_msgId(), values)


def with_names(message: int, values: tuple[Any, ...]) -> tuple[Any, ...]:
    """The `values` of a message in wire order, as one of protocol/messages.py where that has it."""
    kind = BY_ID.get(message)
    return kind._make(values) if kind else values


def as_request(message: dialect.MAVLink_message) -> Message:
    """A pymavlink message as (id, values in wire order)."""
    return message.get_msgId(), wire_values(message)


def carries_control(datagram: bytes) -> bool:
    """True if a frame that only the control side may send could be found anywhere in `datagram`."""
    start = datagram.find(MARKER_2)
    while start >= 0:
        if message_id(datagram, start) in CONTROL_ONLY:
            return True
        start = datagram.find(MARKER_2, start + 1)
    return False


def is_tick(datagram: bytes) -> bool:
    """True for a datagram that starts with a KITE_TICK."""
    return message_id(datagram) == dialect.MAVLINK_MSG_ID_KITE_TICK


def in_datagrams(frames: list[bytes]) -> list[bytes]:
    """Frames gathered into datagrams of at most DATAGRAM bytes, none of them split."""
    datagrams: list[bytes] = []
    for frame in frames:
        if datagrams and len(datagrams[-1]) + len(frame) <= DATAGRAM:
            datagrams[-1] += frame
        else:
            datagrams.append(frame)
    return datagrams
