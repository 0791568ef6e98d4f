"""The .tlog format of MAVLink ground stations: for every frame, big-endian u64 microseconds and then the frame."""

import struct
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType

_STAMP = struct.Struct(">Q")
_MARKER_1, _MARKER_2 = 0xFE, 0xFD
_SIGNED = 0x01
_START = 3  # bytes of a frame that tell its length


def frame_length(start: bytes | bytearray) -> int:
    """Length in bytes of the MAVLink 1 or 2 frame whose first three bytes, or more, are `start`.

    Raises:
        ValueError: this is not the start of a MAVLink frame, or fewer than three bytes are given.
    """
    if len(start) < _START:
        raise ValueError(f"the length of a frame needs {_START} bytes, not {len(start)}")
    if start[0] == _MARKER_1:
        return start[1] + 8
    if start[0] != _MARKER_2:
        raise ValueError(f"no MAVLink frame starts with 0x{start[0]:02X}")
    if start[2] & ~_SIGNED:
        raise ValueError(f"unknown incompatibility flags 0x{start[2]:02X} in a MAVLink 2 frame")
    return start[1] + (25 if start[2] & _SIGNED else 12)


def tlog_entry(time_us: int, frame: bytes) -> bytes:
    """The tlog entry of one complete `frame`, received or sent `time_us` microseconds after 1970 (UTC)."""
    return _STAMP.pack(time_us) + frame


class TlogWriter:
    """Writes a tlog to `path`, as a context manager.

    Raises:
        OSError: the file cannot be made or written.
    """

    def __init__(self, path: str | Path) -> None:
        self._file = Path(path).open("wb")  # noqa: SIM115  (closed by this object's own context)

    def write(self, time_us: int, frame: bytes) -> None:
        """Append one whole MAVLink frame, received or sent `time_us` microseconds after 1970 (UTC)."""
        self._file.write(tlog_entry(time_us, frame))

    def flush(self) -> None:
        """Hand everything written so far to the operating system."""
        self._file.flush()

    def close(self) -> None:
        self._file.close()

    def __enter__(self) -> "TlogWriter":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()


def read_tlog(path: str | Path) -> Iterator[tuple[int, bytes]]:
    """Yield (microseconds, frame) for every frame of the tlog at `path`; a frame cut off at the end is left out.

    Raises:
        ValueError: there is no frame where one should start; names the file and the offset in bytes.
        OSError: the file cannot be read.
    """
    offset = 0
    with Path(path).open("rb") as file:
        while len(head := file.read(_STAMP.size + _START)) == _STAMP.size + _START:
            start = head[_STAMP.size :]
            try:
                missing = frame_length(start) - _START
            except ValueError as error:
                raise ValueError(f"{path}: not a tlog at byte {offset + _STAMP.size}: {error}") from None
            rest = file.read(missing)
            if len(rest) < missing:
                return
            yield _STAMP.unpack_from(head)[0], start + rest
            offset += _STAMP.size + _START + missing
