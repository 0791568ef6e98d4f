"""Finds MAVLink frames, version 1 and 2, in a stream of bytes or in datagrams.

It scans for complete frames instead of running a state machine over each byte: about fifteen times faster on a board.
It never raises; unusable bytes and frames are counted.
"""

import struct

from .crc import START, crc_byte, crc_bytes
from .generated_messages import MESSAGES, TARGETS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Final

    from .crc import Bytes

_V1 = 0xFE  # type: Final
_V2 = 0xFD  # type: Final
_SIGNED = 1  # type: Final
_PEERS = 8  # type: Final  # senders whose sequence numbers are followed
_EVERYBODY = 0  # type: Final  # as the target of a message: any system, any component


class Decoder:
    """`feed` bytes, then call `next_frame` until it returns False; a frame is then in the attributes.

    Frames for other systems and components than `own_system` and `own_component` are only counted in `foreign`;
    an `own_system` of 0 accepts all of them.
    """

    def __init__(self, size: int = 2048) -> None:
        self._buffer: bytearray = bytearray(size)
        self._view: memoryview = memoryview(self._buffer)
        self._payload: bytearray = bytearray(255)
        self._zeros: bytes = bytes(255)
        self._start: int = 0
        self._end: int = 0
        self._next_sequence: dict[int, int] = {}
        self.own_system: int = _EVERYBODY
        self.own_component: int = 1
        self.message: int = 0
        self.sequence: int = 0
        self.system: int = 0
        self.component: int = 0
        self.values: "tuple[Any, ...]" = ()
        self.frames: int = 0
        self.bad_crc: int = 0
        self.unknown: int = 0
        self.foreign: int = 0
        self.lost: int = 0
        self.overflowed: int = 0

    def feed(self, data: "Bytes") -> None:
        """Take in `data`. What does not fit is dropped and counted in `overflowed` [bytes]."""
        if self._start:
            rest = self._end - self._start
            self._view[:rest] = self._view[self._start : self._end]
            self._start = 0
            self._end = rest
        room = len(self._buffer) - self._end
        size = len(data)
        if size > room:
            self.overflowed += size - room
            size = room
            data = memoryview(data)[:size]
        self._view[self._end : self._end + size] = data
        self._end += size

    def next_frame(self, whole: bool = False) -> bool:  # noqa: PLR0912  in one piece, as calls cost a board much
        """Find the next good frame; False when there is none.

        `whole`: the bytes end with a datagram, so an incomplete frame stays incomplete.
        """
        buffer = self._buffer
        end = self._end
        while self._start < end:
            start = self._start
            marker = buffer[start]
            if marker == _V2:
                header = 10
            elif marker == _V1:
                header = 6
            else:
                self._start = start + 1
                continue
            left = end - start
            size = length = message = 0
            entry = None
            if left >= header:
                length = buffer[start + 1]
                size = header + length + 2
                if marker == _V1:
                    message = buffer[start + 5]
                    entry = MESSAGES.get(message)
                else:
                    message = buffer[start + 7] | buffer[start + 8] << 8 | buffer[start + 9] << 16
                    flags = buffer[start + 2]
                    if flags & _SIGNED:
                        size += 13
                    if not flags & ~_SIGNED:  # else it needs a feature that we do not have
                        entry = MESSAGES.get(message)
            if not size or size > left:
                if not whole:
                    return False
            elif entry is None:
                if self._skip_unknown(header, size):
                    continue
            elif self._is_whole(start, start + header + length, entry):
                accepted = self._accept(start + header, length, message, entry)
                self._start = start + size
                if accepted:
                    return True
                continue
            self._start = start + 1
        return False

    def _skip_unknown(self, header: int, size: int) -> bool:
        """Step over a frame of an unknown message if what follows it looks like a frame, or like the end."""
        behind = self._start + size
        if behind < self._end and self._buffer[behind] not in (_V2, _V1):
            return False
        self.unknown += 1
        self._follow_sequence(self._start + header - (6 if header == 10 else 4), False)
        self._start = behind
        return True

    def _is_whole(self, start: int, end: int, entry: tuple[str, int, int, int]) -> bool:
        """True if the checksum is right of the frame at `start`, whose payload goes to `end`."""
        buffer = self._buffer
        _, extra, _, _ = entry
        if crc_byte(extra, crc_bytes(buffer, start + 1, end, START)) == buffer[end] | buffer[end + 1] << 8:
            return True
        self.bad_crc += 1
        return False

    def _accept(self, payload: int, length: int, message: int, entry: tuple[str, int, int, int]) -> bool:
        """The one place that accepts or rejects a frame that came whole (a signature would be checked here too).

        The frame's `payload` has this `length`; `entry` is the message's in MESSAGES.
        """
        buffer = self._buffer
        sequence = payload - (6 if buffer[self._start] == _V2 else 4)
        layout, _, full_length, _ = entry
        is_ours = not self.own_system or message not in TARGETS or self._is_ours(payload, length, TARGETS[message])
        self._follow_sequence(sequence, is_ours)
        if not is_ours:
            self.foreign += 1
            return False
        self.message = message
        self.sequence = buffer[sequence]
        self.system = buffer[sequence + 1]
        self.component = buffer[sequence + 2]
        if length >= full_length:
            self.values = struct.unpack_from(layout, buffer, payload)
        else:  # trailing zeros were not sent
            self._payload[:length] = self._view[payload : payload + length]
            self._payload[length:full_length] = self._zeros[: full_length - length]
            self.values = struct.unpack_from(layout, self._payload, 0)
        self.frames += 1
        return True

    def _is_ours(self, payload: int, length: int, targets: tuple[int, int]) -> bool:
        """True if a payload with its `targets` at these offsets (see TARGETS) is for this system, or for all."""
        system, component = targets
        return self._says(payload, length, system, self.own_system) and self._says(
            payload, length, component, self.own_component)

    def _says(self, payload: int, length: int, at: int, wanted: int) -> bool:
        """True if the target at this offset, where there is one, is the `wanted` one, or everybody."""
        if not 0 <= at < length:  # zeros at a payload's end are not sent
            return True
        return self._buffer[payload + at] in (_EVERYBODY, wanted)

    def _follow_sequence(self, at: int, fresh: bool) -> None:
        """Count the frames missing before the one whose sequence number, system and component lie at `at`.

        Only a frame that is whole and for us may bring in a new sender.
        """
        buffer = self._buffer
        sequence = buffer[at]
        sender = buffer[at + 1] << 8 | buffer[at + 2]
        expected = self._next_sequence.get(sender)
        if expected is None:
            if not fresh or len(self._next_sequence) >= _PEERS:
                return
            expected = sequence
        missing = (sequence - expected) & 0xFF
        if missing < 128:  # else it is a copy, or came late
            self.lost += missing
            self._next_sequence[sender] = (sequence + 1) & 0xFF
