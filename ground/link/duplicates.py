"""Tells the first copy of a frame from those that come after it over another link."""

from collections import deque

from protocol.frame import Address

_REMEMBERED = 128  # half of the sequence numbers: an equal frame further back is another message


class FirstCopies:
    """Remembers each sender's latest frames. Two frames are copies when all of their bytes agree."""

    def __init__(self) -> None:
        self._frames: dict[Address, set[bytes]] = {}
        self._order: dict[Address, deque[bytes]] = {}

    def is_first(self, sender: Address, frame: bytes) -> bool:
        """Whether this frame of `sender` has not come before; remembers it."""
        known = self._frames.setdefault(sender, set())
        if frame in known:
            return False
        order = self._order.setdefault(sender, deque())
        known.add(frame)
        order.append(frame)
        if len(order) > _REMEMBERED:
            known.discard(order.popleft())
        return True
