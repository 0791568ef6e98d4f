"""Tells commands that move the kite from late copies of them, over however many links a station sends.

A station numbers what it sends, whatever link that goes over. A copy over a slow link may arrive when a later command
was obeyed already: it must not undo that one, nor what another station or a fail-safe did since.
"""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

_RECENT_US = 3000000  # type: Final  # no link that is flown by is later; beyond it a station may have begun anew
_BEHIND = 32  # type: Final  # numbers; further back it is a station that begins anew
_REMEMBERED = 8  # type: Final


class CommandOrder:
    """Remembers the last few commands that were answered: obeyed, overtaken while they waited, or refused."""

    def __init__(self) -> None:
        # (sender, sequence, what, whether it was refused, time), the newest last
        self._done: list[tuple[int, int, tuple[int, float], bool, int]] = []

    def is_late(
        self, sender: int, sequence: int | None, what: tuple[int, float], is_safe: bool, uptime_us: int
    ) -> bool:
        """True for a frame that was answered before, or that was sent before one that was answered and not refused.

        `what` it asks for. One that `is_safe` (PARK, MANUAL or disarm) is late only as the very frame. `sequence` None:
        nothing is known of the order.
        """
        if sequence is None:
            return False
        for other, number, asked, refused, time_us in self._done:
            if other != sender or uptime_us - time_us >= _RECENT_US:
                continue
            if number == sequence and asked == what:
                return True
            if not (is_safe or refused) and (number - sequence) & 0xFF <= _BEHIND:
                return True
        return False

    def was_refused(self, sender: int, sequence: int | None, what: tuple[int, float]) -> bool:
        """True for a frame that was refused when it came first, and its station told why."""
        return (sender, sequence, what, True) in [done[:4] for done in self._done]

    def note(self, sender: int, sequence: int | None, what: tuple[int, float], refused: bool, uptime_us: int) -> None:
        """A command was answered; one without a number says nothing of the order."""
        if sequence is None:
            return
        self._done = self._done[1 - _REMEMBERED :]
        self._done.append((sender, sequence, what, refused, uptime_us))
