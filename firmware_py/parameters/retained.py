"""What is needed to resume a flight after a watchdog reset, in memory that survives it.

Parameters that were changed in flight are not on flash yet, and the board must know that it was flying.
"""

import struct

from ..mavlink.crc import START, crc_bytes
from ..mavlink.generated_messages import CONTRACT_HASH
from .generated_parameters import COUNT

_CONTRACT = CONTRACT_HASH.encode()  # another firmware's values would be misread
_LAYOUT = "<16sB%df" % COUNT


class Recovery:
    """Over `retained`: read() -> bytes, write(data); some 20 bytes and 4 for each parameter are used."""

    def __init__(self, retained):
        self._retained = retained
        self._end = struct.calcsize(_LAYOUT)
        self._buffer = bytearray(self._end + 2)

    def write(self, parameters, armed):
        """Store all values, and whether the kite is armed. Takes a board 2 ms: call it on a change, not each tick."""
        buffer = self._buffer
        struct.pack_into(_LAYOUT, buffer, 0, _CONTRACT, armed, *parameters.values)
        struct.pack_into("<H", buffer, self._end, crc_bytes(buffer, 0, self._end, START))
        self._retained.write(buffer)

    def load(self, parameters):
        """Set `parameters` from memory; return whether the kite was armed, or None if there is nothing valid."""
        data = self._retained.read()
        end = self._end
        if len(data) < end + 2 or struct.unpack_from("<H", data, end)[0] != crc_bytes(data, 0, end, START):
            return None
        contract, armed, *values = struct.unpack_from(_LAYOUT, data, 0)
        if contract != _CONTRACT:
            return None
        for index in range(COUNT):
            value = values[index]
            if not parameters.refusal(index, value, False):
                parameters.set(index, value)
        return bool(armed)
