"""Finds MAVLink messages in a stream of bytes, whatever else it contains."""

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

from protocol import dialect
from protocol.frame import Header, frame_length, read_header

Message = dialect.MAVLink_message
_REPLACEMENT = "\N{REPLACEMENT CHARACTER}"
_MARKERS = (dialect.PROTOCOL_MARKER_V1, dialect.PROTOCOL_MARKER_V2)


class Received(NamedTuple):
    """One message with its texts made printable, its header, and the frame as received."""

    message: Message
    header: Header
    frame: bytes


class FrameReader:
    """Finds frames in bytes as they arrive. A bad frame costs only itself: the search resumes one byte on."""

    def __init__(self) -> None:
        self._decoder = dialect.MAVLink(None)
        self._buffer = bytearray()

    def feed(self, data: bytes) -> Iterator[Received]:
        """Add `data`, and yield every message that is complete and passes its checksum. Never raises."""
        self._buffer += data
        while (start := self._find_marker()) is not None and len(self._buffer) - start >= 3:
            del self._buffer[:start]
            try:
                length = frame_length(self._buffer)
            except ValueError:
                del self._buffer[:1]
                continue
            if len(self._buffer) < length:
                break
            received = self._decode(self._buffer[:length])
            certain = received is not None and not isinstance(received.message, dialect.MAVLink_unknown)
            del self._buffer[: length if certain else 1]  # an unknown message may be noise that contains a good one
            if received:
                yield received

    def _find_marker(self) -> int | None:
        """Where the next frame may start; drops everything if nowhere."""
        found = [at for at in (self._buffer.find(marker) for marker in _MARKERS) if at >= 0]
        if not found:
            self._buffer.clear()
            return None
        return min(found)

    def _decode(self, frame: bytearray) -> Received | None:
        try:
            message = self._decoder.decode(bytearray(frame))
        except dialect.MAVError:
            return None
        if isinstance(message, dialect.MAVLink_unknown) and not self._ends_cleanly(len(frame)):
            return None
        make_printable(message)
        return Received(message, read_header(frame), bytes(frame))

    def _ends_cleanly(self, length: int) -> bool:
        """Whether a frame or nothing follows, the only way to tell an unknown message from noise."""
        return len(self._buffer) == length or self._buffer[length] in _MARKERS


def make_printable(message: dialect.MAVLink_message) -> None:
    """Replace unprintable characters in all texts and names of `message`. Its frame stays as received."""
    for field in _text_fields(type(message)):
        setattr(message, field, _printable(getattr(message, field)))


def _printable(text: str) -> str:
    """`text` with a replacement character for each escape, line break or other unprintable character."""
    return text if text.isprintable() else "".join(letter if letter.isprintable() else _REPLACEMENT for letter in text)


@cache
def _text_fields(kind: type[dialect.MAVLink_message]) -> tuple[str, ...]:
    return tuple(name for name, field in zip(kind.fieldnames, kind.fieldtypes, strict=True) if field == "char")
