"""What outlives a reset but not a loss of power: one layout on every board.

| part | offset | bytes | holds | checked by |
|---|---|---|---|---|
| header | 0 | 8 | magic, version of this layout, SIZE | its value: without it nothing is believed |
| signing time | 8 | 8 | MAVLink's signing timestamp: 48 bits, units of 10 us | CRC |
| events | 16 | 224 | a ring of 16 entries of 14 bytes | a CRC for each entry |
| flight | 240 | 416 | the contract's hash, armed or not, the parameters: room for 99 | CRC |

Each part is whole or lost on its own. A firmware with another contract keeps the events and the signing time. Raise
_VERSION when an offset or the meaning of a part changes.
"""

import struct

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Final

SIGNING_TIME = 8  # type: Final
SIGNING_TIME_BYTES = 8  # type: Final
EVENTS = 16  # type: Final
EVENT_BYTES = 14  # type: Final
EVENT_COUNT = 16  # type: Final  # divides 2^16
FLIGHT = 240  # type: Final
FLIGHT_BYTES = 416  # type: Final
SIZE = 656  # type: Final

_VERSION = 1  # type: Final
_HEADER = struct.pack("<4sHH", b"KITE", _VERSION, SIZE)  # type: Final


def take_over(block: bytearray, old: bytes | bytearray | None) -> None:
    """Fill `block` with `old` if that is a block of this layout, else only with the header."""
    if old is not None and len(old) == SIZE and old[: len(_HEADER)] == _HEADER:
        block[:] = old
    else:
        block[: len(_HEADER)] = _HEADER


class Retained:
    """A block of SIZE bytes that is retained. `store(block)` is called after each write, where one is given."""

    def __init__(self, block: bytearray, store: "Callable[[bytearray], object] | None" = None) -> None:
        self._block = block
        self._store = store

    def read(self, offset: int, size: int) -> bytearray:
        """`size` bytes from `offset` on."""
        return self._block[offset : offset + size]

    def write(self, offset: int, data: bytes | bytearray) -> None:
        """Put `data` at `offset`."""
        self._block[offset : offset + len(data)] = data
        if self._store is not None:
            self._store(self._block)
