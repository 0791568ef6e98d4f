"""The .tlog format of MAVLink ground stations: for every frame, big-endian u64 microseconds and then the frame."""

import struct
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType

from protocol.frame import START, frame_length

_STAMP = struct.Struct(">Q")


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
        while len(head := file.read(_STAMP.size + START)) == _STAMP.size + START:
            start = head[_STAMP.size :]
            try:
                missing = frame_length(start) - START
            except ValueError as error:
                raise ValueError(f"{path}: not a tlog at byte {offset + _STAMP.size}: {error}") from None
            rest = file.read(missing)
            if len(rest) < missing:
                return
            stamp_us, = _STAMP.unpack_from(head)
            yield stamp_us, start + rest
            offset += _STAMP.size + START + missing
