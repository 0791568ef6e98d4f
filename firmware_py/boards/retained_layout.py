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

SIGNING_TIME = 8
SIGNING_TIME_BYTES = 8
EVENTS = 16
EVENT_BYTES = 14
EVENT_COUNT = 16  # divides 2^16
FLIGHT = 240
FLIGHT_BYTES = 416
SIZE = 656

_VERSION = 1
_HEADER = struct.pack("<4sHH", b"KITE", _VERSION, SIZE)


def take_over(block, old):
    """Fill `block` with `old` if that is a block of this layout, else only with the header."""
    if old is not None and len(old) == SIZE and old[: len(_HEADER)] == _HEADER:
        block[:] = old
    else:
        block[: len(_HEADER)] = _HEADER


class Retained:
    """A block of SIZE bytes that is retained. `store(block)` is called after each write, where one is given."""

    def __init__(self, block, store=None):
        self._block = block
        self._store = store

    def read(self, offset, size):
        """`size` bytes from `offset` on."""
        return self._block[offset : offset + size]

    def write(self, offset, data):
        """Put `data` at `offset`."""
        self._block[offset : offset + len(data)] = data
        if self._store is not None:
            self._store(self._block)
