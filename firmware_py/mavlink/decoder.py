"""Finds MAVLink frames, version 1 and 2, in a stream of bytes or in datagrams.

It scans for complete frames instead of running a state machine over each byte: about fifteen times faster on a board.
It never raises; unusable bytes and frames are counted.
"""

import struct

from .crc import START, crc_byte, crc_bytes
from .generated_messages import MESSAGES, TARGETS

_V1 = 0xFE
_V2 = 0xFD
_SIGNED = 1
_PEERS = 8  # senders whose sequence numbers are followed
_EVERYBODY = 0  # as the target of a message: any system, any component


class Decoder:
    """`feed` bytes, then call `next_frame` until it returns False; a frame is then in the attributes.

    Frames for other systems and components than `own_system` and `own_component` are only counted in `foreign`;
    an `own_system` of 0 accepts all of them.
    """

    def __init__(self, size=2048):
        self._buffer = bytearray(size)
        self._view = memoryview(self._buffer)
        self._payload = bytearray(255)
        self._zeros = bytes(255)
        self._start = 0
        self._end = 0
        self._next_sequence = {}
        self.own_system = _EVERYBODY
        self.own_component = 1
        self.message = 0
        self.sequence = 0
        self.system = 0
        self.component = 0
        self.values = ()
        self.frames = 0
        self.bad_crc = 0
        self.unknown = 0
        self.foreign = 0
        self.lost = 0
        self.overflowed = 0

    def feed(self, data):
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

    def next_frame(self, whole=False):
        """Find the next good frame; False when there is none.

        `whole`: the bytes end with a datagram, so an incomplete frame stays incomplete.
        """
        buffer = self._buffer
        while self._start < self._end:
            marker = buffer[self._start]
            if marker in (_V2, _V1):
                size = self._frame_size(marker)
                if not size or abs(size) > self._end - self._start:
                    if not whole:
                        return False
                elif size > 0 and self._is_whole(marker):
                    accepted = self._accept(marker)
                    self._start += size
                    if accepted:
                        return True
                    continue
                elif size < 0 and self._skip_unknown(marker, -size):
                    continue
            self._start += 1
        return False

    def _frame_size(self, marker):
        """Size of the frame at the start; 0 if too little of it is there, negative for a message not known."""
        buffer = self._buffer
        start = self._start
        if self._end - start < (10 if marker == _V2 else 6):
            return 0
        length = buffer[start + 1]
        message = self._message_at(marker)
        if marker == _V1:
            size = 8 + length
        else:
            size = 25 + length if buffer[start + 2] & _SIGNED else 12 + length
            if buffer[start + 2] & ~_SIGNED:
                return -size  # needs a feature that we do not have
        return size if message in MESSAGES else -size

    def _skip_unknown(self, marker, size):
        """Step over a frame of an unknown message if what follows it looks like a frame, or like the end."""
        behind = self._start + size
        if behind < self._end and self._buffer[behind] not in (_V2, _V1):
            return False
        self.unknown += 1
        self._follow_sequence(self._start + (4 if marker == _V2 else 2), False)
        self._start = behind
        return True

    def _is_whole(self, marker):
        """True if the checksum of the frame at the start, of a known message, is right."""
        buffer = self._buffer
        start = self._start
        end = start + (10 if marker == _V2 else 6) + buffer[start + 1]
        _, extra, _, _ = MESSAGES[self._message_at(marker)]
        if crc_byte(extra, crc_bytes(buffer, start + 1, end, START)) == buffer[end] | buffer[end + 1] << 8:
            return True
        self.bad_crc += 1
        return False

    def _accept(self, marker):
        """The one place that accepts or rejects a frame that came whole (a signature would be checked here too)."""
        buffer = self._buffer
        sequence = self._start + (4 if marker == _V2 else 2)
        payload = self._start + (10 if marker == _V2 else 6)
        length = buffer[self._start + 1]
        message = self._message_at(marker)
        layout, _, full_length, _ = MESSAGES[message]
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

    def _message_at(self, marker):
        """The message id of the frame at the start."""
        buffer = self._buffer
        start = self._start
        if marker == _V1:
            return buffer[start + 5]
        return buffer[start + 7] | buffer[start + 8] << 8 | buffer[start + 9] << 16

    def _is_ours(self, payload, length, targets):
        """True if a payload with its `targets` at these offsets (see TARGETS) is for this system, or for all."""
        system, component = targets
        return self._says(payload, length, system, self.own_system) and self._says(
            payload, length, component, self.own_component)

    def _says(self, payload, length, at, wanted):
        """True if the target at this offset, where there is one, is the `wanted` one, or everybody."""
        if not 0 <= at < length:  # zeros at a payload's end are not sent
            return True
        return self._buffer[payload + at] in (_EVERYBODY, wanted)

    def _follow_sequence(self, at, fresh):
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
