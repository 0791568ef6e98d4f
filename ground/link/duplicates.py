"""Distinguishes the first copy of a frame from later ones over other links."""

from collections import deque

from protocol.frame import Address

_REMEMBERED = 128  # half of the sequence numbers: an equal frame from further back is a new message


class FirstCopies:
    """Remembers each sender's latest frames. Frames are copies if all their bytes are equal."""

    def __init__(self) -> None:
        self._frames: dict[Address, set[bytes]] = {}
        self._order: dict[Address, deque[bytes]] = {}

    def is_first(self, sender: Address, frame: bytes) -> bool:
        """Whether this is the first copy of the frame from `sender`; remembers it."""
        known = self._frames.setdefault(sender, set())
        if frame in known:
            return False
        order = self._order.setdefault(sender, deque())
        known.add(frame)
        order.append(frame)
        if len(order) > _REMEMBERED:
            known.discard(order.popleft())
        return True
