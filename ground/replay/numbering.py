"""Sequence numbers of a replay: messages lost in the recording stay missing, and no others are."""

from protocol import dialect
from protocol.frame import read_header, with_sequence


class Numbering:
    """Numbers the frames of one sender: recorded ones keep their gaps, added ones shift what follows."""

    def __init__(self) -> None:
        self._shift = 0
        self._next: int | None = None
        self._fresh = True

    def recorded(self, frame: bytes) -> bytes:
        """A frame of the recording, renumbered to be sent."""
        sequence = read_header(frame).sequence
        if self._fresh and self._next is not None:
            self._shift = self._next - sequence
        self._fresh = False
        number = (sequence + self._shift) % 256
        if self._next is None or (number - self._next) % 256 < 128:  # not for one that was overtaken
            self._next = (number + 1) % 256
        return renumbered(frame, number)

    def added(self, frame: bytes) -> bytes:
        """A frame that is not in the recording here, numbered to be sent."""
        number = self._next or 0
        self._next = (number + 1) % 256
        self._shift += 1
        return renumbered(frame, number)

    def left_out(self) -> None:
        """Skip a recorded frame, so that it does not count as lost."""
        self._shift -= 1

    def start_over(self) -> None:
        """Number the next recorded frame after the last one sent, whatever its own number."""
        self._fresh = True


def renumbered(frame: bytes, sequence: int) -> bytes:
    """The same frame with another sequence number; a signed one is unchanged, as it cannot be signed again.

    The checksum is linear: the change from the new number does not depend on the message's CRC extra, so that frames
    of unknown types can be renumbered too.
    """
    header = read_header(frame)
    if header.signed:
        return frame
    changed, end = with_sequence(frame, sequence), header.payload_end
    old, new = (dialect.x25crc(text[1:end] + b"\0").crc for text in (frame, changed))
    checksum = int.from_bytes(frame[end:], "little") ^ old ^ new
    return changed[:end] + checksum.to_bytes(2, "little")
