"""The parts of retained memory (boards/retained_layout.py): a flight to resume, a ring of events, a signing time.

Parameters that were changed in flight are not on flash yet, and the board must know that it was flying.
"""

import struct

from ..boards.retained_layout import EVENT_BYTES, EVENT_COUNT, EVENTS, FLIGHT, SIGNING_TIME, SIGNING_TIME_BYTES
from ..mavlink.crc import START, crc_bytes
from ..mavlink.generated_messages import CONTRACT_HASH
from .generated_parameters import COUNT

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final, TypeAlias

    from ..boards.interface import Retained
    from .values import Parameters

    Event: TypeAlias = tuple[int, int, int, float]

_CONTRACT = CONTRACT_HASH.encode()  # type: Final  # another firmware's values would be misread
_FLIGHT = "<16sB%df" % COUNT  # type: Final
_EVENT = "<HHIf"  # type: Final  # number, code, uptime [ms], value
_ROUND = 0x10000  # type: Final
_HALF = 0x8000  # type: Final


def _sealed(data: bytes | bytearray) -> bool:
    """True if `data` ends with the CRC of what is before it."""
    end = len(data) - 2
    checksum: int = struct.unpack_from("<H", data, end)[0]
    return checksum == crc_bytes(data, 0, end, START)


def _seal(data: bytearray) -> bytearray:
    """Set the CRC at the end of `data`."""
    end = len(data) - 2
    struct.pack_into("<H", data, end, crc_bytes(data, 0, end, START))
    return data


class Recovery:
    """The flight: all parameters, and whether the kite was armed."""

    def __init__(self, retained: "Retained") -> None:
        self._retained = retained
        self._buffer: bytearray = bytearray(struct.calcsize(_FLIGHT) + 2)

    def write(self, parameters: "Parameters", armed: bool) -> None:
        """Store all values, and whether the kite is armed. Takes a board 2 ms: call it on a change, not each tick."""
        struct.pack_into(_FLIGHT, self._buffer, 0, _CONTRACT, armed, *parameters.values)
        self._retained.write(FLIGHT, _seal(self._buffer))

    def load(self, parameters: "Parameters") -> bool | None:
        """Set `parameters` from memory; return whether the kite was armed, or None if there is nothing valid."""
        data = self._retained.read(FLIGHT, len(self._buffer))
        if not _sealed(data):
            return None
        contract, armed, *values = struct.unpack_from(_FLIGHT, data, 0)
        if contract != _CONTRACT:
            return None
        for index in range(COUNT):
            value = values[index]
            if not parameters.refusal(index, value, False):
                parameters.set(index, value)
        return bool(armed)


class EventRing:
    """The last EVENT_COUNT events, over resets; one that was being written in a reset is lost, the others are not."""

    def __init__(self, retained: "Retained") -> None:
        self._retained = retained
        self._buffer: bytearray = bytearray(EVENT_BYTES)
        self._next: int = 0
        for number, _, _, _ in self.entries():
            self._next = (number + 1) % _ROUND

    def append(self, code: int, value: float, uptime_ms: int) -> None:
        """Note an event of boards/interface.py [ms since the start, below 2^32] in the place of the oldest."""
        number = self._next
        struct.pack_into(_EVENT, self._buffer, 0, number, code, uptime_ms, value)
        self._retained.write(EVENTS + number % EVENT_COUNT * EVENT_BYTES, _seal(self._buffer))
        self._next = (number + 1) % _ROUND

    def entries(self) -> "list[Event]":
        """Each whole event, oldest first: (number, code, uptime [ms], value). Numbers count on, modulo 2^16."""
        found: "list[Event]" = []
        for place in range(EVENT_COUNT):
            data = self._retained.read(EVENTS + place * EVENT_BYTES, EVENT_BYTES)
            if _sealed(data):
                found.append(struct.unpack_from(_EVENT, data, 0))
        if found:
            any_of_them = found[0]
            found.sort(key=lambda event: _distance(any_of_them, event))
        return found


def _distance(event: "Event", other: "Event") -> int:
    """By how much an event is before another, in numbers, beginning with half of them after it."""
    number, _, _, _ = event
    other_number, _, _, _ = other
    return (other_number - number + _HALF) % _ROUND


class SigningTime:
    """MAVLink's signing timestamp [10 us since 2015], which must not go back: 48 bits."""

    def __init__(self, retained: "Retained") -> None:
        self._retained = retained

    def write(self, timestamp: int) -> None:
        """Store it."""
        data = bytearray(SIGNING_TIME_BYTES)
        data[:6] = timestamp.to_bytes(6, "little")
        self._retained.write(SIGNING_TIME, _seal(data))

    def read(self) -> int | None:
        """The timestamp, or None if there is none."""
        data = self._retained.read(SIGNING_TIME, SIGNING_TIME_BYTES)
        return int.from_bytes(data[:6], "little") if _sealed(data) else None
