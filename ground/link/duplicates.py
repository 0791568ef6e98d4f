"""Tells the first copy of a frame from those that come after it over another link."""

from collections import deque

_REMEMBERED = 128  # half of the sequence numbers: an equal frame further back is another message


class FirstCopies:
    """Remembers each sender's latest frames. Two frames are copies when all of their bytes agree."""

    def __init__(self) -> None:
        self._frames: dict[tuple[int, int], set[bytes]] = {}
        self._order: dict[tuple[int, int], deque[bytes]] = {}

    def is_first(self, sender: tuple[int, int], frame: bytes) -> bool:
        """Whether this frame of `sender` (system, component) has not come before; remembers it."""
        known = self._frames.setdefault(sender, set())
        if frame in known:
            return False
        order = self._order.setdefault(sender, deque())
        known.add(frame)
        order.append(frame)
        if len(order) > _REMEMBERED:
            known.discard(order.popleft())
        return True
