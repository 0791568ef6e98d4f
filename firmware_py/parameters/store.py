"""The parameters on flash: two slots, neither of which a power cut can corrupt.

A record is a header (magic, generation, count), `count` entries (name, value) and a CRC-16 over all of it. The values
are float32, byte by byte as they were set. The newest valid record counts. A save goes into a temporary file, which
then replaces the other slot: whenever the power fails, the last stored set is still there, complete.
"""

import struct

from ..mavlink.crc import START, crc_bytes
from .generated_parameters import COUNT, DEFAULTS, FLAGS, NAMES, READ_ONLY
from .values import UNKNOWN

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

    from ..boards.interface import Storage
    from .values import Parameters

SLOTS = ("parameters_a.bin", "parameters_b.bin")  # type: Final[tuple[str, ...]]
TEMPORARY = "parameters.tmp"  # type: Final
_MAGIC = b"KPR1"  # type: Final
_HEADER = "<4sIH"  # type: Final
_HEADER_BYTES = 10  # type: Final
_ENTRY = "<16sf"  # type: Final
_ENTRY_BYTES = 20  # type: Final
_CRC_BYTES = 2  # type: Final


class LoadReport:
    """Result of a load; names are str."""

    def __init__(self) -> None:
        self.found: bool = False  # there was a whole record
        self.damaged: int = 0  # slots that hold something else
        self.loaded: int = 0  # values taken
        self.unknown: list[str] = []  # stored, but there is no such parameter here
        self.refused: list[str] = []  # stored with a value that is out of range here, or read-only here
        self.missing: list[str] = []  # not stored: at its default


class ParameterStore:
    """Over `storage`, small files as described in boards/interface.py, where a rename replaces a file in one step."""

    def __init__(self, storage: "Storage") -> None:
        self._storage = storage

    def load(self, parameters: "Parameters") -> "LoadReport":
        """Set `parameters` to their stored values, or to defaults if there are none; return a LoadReport.

        If no valid record is found, nothing is set.
        """
        report = LoadReport()
        record, _, _ = self._newest(report)
        if record is not None:
            report.found = True
            values = self._unpack(record, parameters, report)
            for index in range(len(values)):
                parameters.set(index, values[index])
        return report

    def holds(self, parameters: "Parameters") -> bool:
        """True if the newest record holds exactly these values."""
        newest, _, generation = self._newest(LoadReport())
        return newest is not None and _entries(newest) == _entries(_pack(parameters, generation))

    def save(self, parameters: "Parameters") -> bool:
        """Store `parameters`; return False if the storage failed. Writes nothing if they are stored already.

        Stalls a board for about 100 ms, and wears the flash: call it only when disarmed.
        """
        newest, slot, generation = self._newest(LoadReport())
        record = _pack(parameters, generation + 1)
        if newest is not None and _entries(newest) == _entries(record):
            return True
        try:
            self._storage.write(TEMPORARY, record)
            if self._storage.read(TEMPORARY) != record:  # flash that is full or worn out
                return False
            self._storage.rename(TEMPORARY, SLOTS[1 - slot])
        except OSError:
            return False
        return True

    def _newest(self, report: "LoadReport") -> tuple[bytes | None, int, int]:
        """(record or None, its slot, its generation) of the newest whole record."""
        newest = None
        slot = 1  # so that the first record goes to slot 0
        generation = 0
        for index in range(2):
            data = self._read(SLOTS[index])
            if data is None:
                continue
            if not _is_whole(data):
                report.damaged += 1
                continue
            _, found, _ = struct.unpack_from(_HEADER, data, 0)
            if newest is None or found > generation:
                newest = data
                slot = index
                generation = found
        return newest, slot, generation

    def _read(self, name: str) -> bytes | None:
        try:
            return self._storage.read(name)
        except OSError:
            return b""  # there, but not to be read: damaged

    def _unpack(self, record: bytes, parameters: "Parameters", report: "LoadReport") -> list[float]:
        """All values as `record` has them, with defaults for the rest."""
        values = list(DEFAULTS)
        stored = [False] * len(values)
        for offset in range(_HEADER_BYTES, len(record) - _CRC_BYTES, _ENTRY_BYTES):
            name, value = struct.unpack_from(_ENTRY, record, offset)
            index = parameters.index_of(name)
            if index == UNKNOWN:
                report.unknown.append(_text(name))
                continue
            stored[index] = True
            if parameters.refusal(index, value, False):
                report.refused.append(_text(name))
            else:
                values[index] = value
                report.loaded += 1
        for index in range(len(values)):
            if not stored[index] and not FLAGS[index] & READ_ONLY:
                report.missing.append(NAMES[index].decode())
        return values


def _entries(record: bytes) -> bytes:
    """Names and values of a record."""
    return record[_HEADER_BYTES:-_CRC_BYTES]


def _pack(parameters: "Parameters", generation: int) -> bytes:
    """The record of all parameters that can be set."""
    kept = [index for index in range(COUNT) if not FLAGS[index] & READ_ONLY]
    record = bytearray(_HEADER_BYTES + len(kept) * _ENTRY_BYTES + _CRC_BYTES)
    struct.pack_into(_HEADER, record, 0, _MAGIC, generation, len(kept))
    offset = _HEADER_BYTES
    for index in kept:
        struct.pack_into(_ENTRY, record, offset, NAMES[index], parameters.values[index])
        offset += _ENTRY_BYTES
    struct.pack_into("<H", record, offset, crc_bytes(record, 0, offset, START))
    return bytes(record)


def _is_whole(data: bytes) -> bool:
    """True for a record with all its bytes, as they were written."""
    if len(data) < _HEADER_BYTES + _CRC_BYTES or data[:4] != _MAGIC:
        return False
    _, _, count = struct.unpack_from(_HEADER, data, 0)
    end = _HEADER_BYTES + count * _ENTRY_BYTES
    if len(data) != end + _CRC_BYTES:
        return False
    checksum: int = struct.unpack_from("<H", data, end)[0]
    return checksum == crc_bytes(data, 0, end, START)


def _text(name: bytes) -> str:
    """A stored name as str, whatever its bytes are."""
    return "".join([chr(byte) for byte in name if 32 <= byte < 127])
