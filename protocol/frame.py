"""A MAVLink frame's header, in version 1 and 2: who sent which message, with which number, and where its parts lie."""

import struct
from typing import NamedTuple

MARKER_1, MARKER_2 = 0xFE, 0xFD
START = 3  # bytes of a frame that tell its length
_SIGNED = 0x01
_HEAD_1 = struct.Struct("<BBBBBB")  # marker, length, sequence, system, component, message
_HEAD_2 = struct.Struct("<BBBBBBBHB")  # marker, length, incompatible, compatible, sequence, system, component, message
_CHECKSUM, _SIGNATURE = 2, 13


class Address(NamedTuple):
    """Who on the MAVLink network: system and component id."""

    system: int
    component: int


class Header(NamedTuple):
    """What stands before a frame's payload of `payload_bytes`; `message` is the message's id."""

    version: int
    payload_bytes: int
    signed: bool
    sequence: int
    sender: Address
    message: int

    @property
    def payload_start(self) -> int:
        """Where in the frame the payload begins."""
        return _HEAD_1.size if self.version == 1 else _HEAD_2.size

    @property
    def payload_end(self) -> int:
        """Where in the frame the checksum stands."""
        return self.payload_start + self.payload_bytes


def read_header(frame: bytes | bytearray) -> Header:
    """The header of a frame that is whole, or at least begins well.

    Raises:
        ValueError: it does not begin as a frame does, or is shorter than a header.
    """
    try:
        if frame[:1] == bytes([MARKER_1]):
            _, payload_bytes, sequence, system, component, message = _HEAD_1.unpack_from(frame)
            return Header(1, payload_bytes, False, sequence, Address(system, component), message)
        if frame[:1] == bytes([MARKER_2]):
            _, payload_bytes, flags, _, sequence, system, component, low, high = _HEAD_2.unpack_from(frame)
            sender = Address(system, component)
            return Header(2, payload_bytes, bool(flags & _SIGNED), sequence, sender, high << 16 | low)
    except struct.error:
        raise ValueError(f"{len(frame)} bytes are no MAVLink header") from None
    raise ValueError(f"no MAVLink frame starts with {bytes(frame[:1]).hex() or 'nothing'}")


def frame_length(start: bytes | bytearray) -> int:
    """Length in bytes of the MAVLink 1 or 2 frame whose first three bytes, or more, are `start`.

    Raises:
        ValueError: this is not the start of a frame that anyone could read, or fewer than three bytes are given.
    """
    if len(start) < START:
        raise ValueError(f"the length of a frame needs {START} bytes, not {len(start)}")
    marker, payload_bytes, flags = start[:START]
    if marker == MARKER_1:
        return _HEAD_1.size + payload_bytes + _CHECKSUM
    if marker != MARKER_2:
        raise ValueError(f"no MAVLink frame starts with 0x{marker:02X}")
    if flags & ~_SIGNED:
        raise ValueError(f"unknown incompatibility flags 0x{flags:02X} in a MAVLink 2 frame")
    return _HEAD_2.size + payload_bytes + _CHECKSUM + (_SIGNATURE if flags & _SIGNED else 0)


def message_id(data: bytes, start: int = 0) -> int:
    """The id in the MAVLink 2 frame that begins at `start`; what is missing at the end of `data` counts as zeros."""
    return int.from_bytes(data[start + 7 : start + _HEAD_2.size], "little")


def payload(frame: bytes, length: int) -> bytes:
    """The frame's payload, with the zeros that MAVLink 2 leaves out, `length` bytes in all."""
    header = read_header(frame)
    return frame[header.payload_start : header.payload_end].ljust(length, b"\0")[:length]


def with_sequence(frame: bytes, sequence: int) -> bytes:
    """The same frame with another sequence number, and the checksum as it was."""
    at = 2 if read_header(frame).version == 1 else 4
    return frame[:at] + bytes([sequence]) + frame[at + 1 :]
