"""Writes MAVLink 2 frames into a preallocated buffer."""

import struct

from .crc import seal
from .generated_messages import MESSAGES

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

    from .interface import Values

LONGEST_FRAME = 280  # type: Final  # header 10, payload 255, CRC 2, signature 13


class Encoder:
    """Numbers the frames of one sender and packs them."""

    def __init__(self, system: int, component: int) -> None:
        self.system = system
        self.component = component
        self.sequence: int = 0

    def encode(self, buffer: bytearray, offset: int, message: int, values: "Values") -> int:
        """Pack `values` (wire order) as a frame of `message` at `buffer[offset:]`; return the offset behind it.

        The buffer must have LONGEST_FRAME bytes left. Trailing zero bytes of the payload are not sent.
        """
        layout, extra, length, _ = MESSAGES[message]
        struct.pack_into(layout, buffer, offset + 10, *values)
        buffer[offset] = 0xFD
        buffer[offset + 2] = 0  # incompatibility flags: not signed
        buffer[offset + 3] = 0
        buffer[offset + 4] = self.sequence
        buffer[offset + 5] = self.system
        buffer[offset + 6] = self.component
        buffer[offset + 7] = message & 0xFF
        buffer[offset + 8] = (message >> 8) & 0xFF
        buffer[offset + 9] = message >> 16
        self.sequence = (self.sequence + 1) & 0xFF
        return seal(buffer, offset, offset + 10 + length, extra)
