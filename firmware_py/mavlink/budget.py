"""The link's budget: bytes per second, from the line rate and from the radio's RADIO_STATUS."""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

_SECOND = 1000000  # type: Final
# A radio's reports are heeded this often at most: it takes a while until one shows an effect.
_REPORT_US = 500000  # type: Final
_FORGET_US = 10000000  # type: Final  # a radio that has told nothing for this long is gone
_LEAST = 200  # type: Final  # bytes a second
# One message in this time is let through although there is no room: a list must come to its end. Acknowledgements come
# more often: a station gives a command up that is not acknowledged.
_SPARE_US = 200000  # type: Final
_ACKNOWLEDGEMENT_SPARE_US = 100000  # type: Final
_MOST = 200000  # type: Final  # beyond it there is no limit to speak of
_LOW = 20  # type: Final  # [% of a radio's buffer left]: far too much is sent
_SCARCE = 50  # type: Final
_PLENTY = 90  # type: Final
# Of a link whose rate nobody told, what answers may take in the long run, and at once [bytes/s, bytes]. A telemetry
# radio of 57600 baud carries 5760 bytes/s, of which telemetry as usual takes 4400, and 2400 where the state is told
# half as often, which it is while answers have taken nearly all that they may. A list of parameters (1.6 KB) goes out
# at once, the parameters' documentation (10 KB) in 3 s: mavsdk gives up on slower files.
_ANSWERS = 2500  # type: Final
_ANSWERS_AT_ONCE = 4000  # type: Final
_CROWDED = 1000  # type: Final  # of these that are left
# Of any link, what acknowledgements of commands may take, 27 a second and 54 at once, and what texts may, 4 and 10:
# apart, so that whoever has texts said cannot keep another's acknowledgement waiting.
_ACKNOWLEDGEMENTS = 600  # type: Final
_ACKNOWLEDGEMENTS_AT_ONCE = 1200  # type: Final
_TEXTS = 240  # type: Final
_TEXTS_AT_ONCE = 600  # type: Final


class LinkBudget:
    """Counts bytes sent against the link's capacity; integers only.

    `most` [bytes/s] is the line's capacity, 0 if unknown. Steering and heartbeats are sent in any case and
    counted; acknowledgements, texts, answers and telemetry, in this order, ask first.
    Answers take at most half the capacity.

    No more is admitted than the line carries in a tick, or the next steering would wait behind it.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self.rate = most  # bytes a second at present, 0 for no limit
        self._left: int = 0
        self._answers_left: int = _ANSWERS_AT_ONCE
        self._acknowledgements_left: int = _ACKNOWLEDGEMENTS_AT_ONCE
        self._texts_left: int = _TEXTS_AT_ONCE
        self._spare = _Spare(_SPARE_US)
        self._answers_spare = _Spare(_SPARE_US)
        self._texts_spare = _Spare(_SPARE_US)
        self._acknowledgements_spare = _Spare(_ACKNOWLEDGEMENT_SPARE_US)
        self._sent: int = 0
        self._measured: int = 0  # bytes of the last whole second
        self._second_us: int = 0
        self._heard_us: int = _FORGET_US  # since the last report heeded
        self._unearned_us: int = 0  # time that what grows with it has not been given yet
        self._waited_us: int = 0  # the same for what grows on a line with a rate

    def refill(self, elapsed_us: int) -> None:
        """Account for the time since the last call [us]."""
        self._second_us += elapsed_us
        if self._second_us >= _SECOND:
            self._measured = self._sent
            self._second_us = self._sent = 0
        if self._heard_us < _FORGET_US:
            self._heard_us += elapsed_us
            if self._heard_us >= _FORGET_US:
                self.rate = self._most
        if elapsed_us > _SECOND:
            elapsed_us = _SECOND
        if self._unearned_us < _SECOND:
            self._unearned_us += elapsed_us
        rate = self.rate
        if rate:
            earned = _bytes_in(rate, elapsed_us)
            most = earned
            if most < rate >> 6:
                most = rate >> 6
            if most > rate >> 2:
                most = rate >> 2
            left = self._left + earned
            self._left = left if left < most else most
            left = self._answers_left + (earned >> 1)
            self._answers_left = left if left < most else most
            if self._waited_us < _SECOND:
                self._waited_us += elapsed_us

    def _earn(self) -> None:
        """Bring up to date what grows with time and is not looked at each tick."""
        elapsed_us = min(self._unearned_us, _SECOND)
        self._unearned_us = 0
        waited_us = self._waited_us
        self._waited_us = 0
        self._spare.refill(waited_us)
        self._answers_spare.refill(waited_us)
        self._texts_spare.refill(waited_us)
        self._acknowledgements_spare.refill(waited_us)
        earned = _bytes_in(_ACKNOWLEDGEMENTS, elapsed_us)
        self._acknowledgements_left = min(self._acknowledgements_left + earned, _ACKNOWLEDGEMENTS_AT_ONCE)
        self._texts_left = min(self._texts_left + _bytes_in(_TEXTS, elapsed_us), _TEXTS_AT_ONCE)
        if not self.rate:
            self._answers_left = min(self._answers_left + _bytes_in(_ANSWERS, elapsed_us), _ANSWERS_AT_ONCE)

    def spend(self, size: int) -> None:
        """Account for `size` bytes that are sent."""
        self._sent += size
        if self.rate:
            self._left = max(self._left - size, -self.rate)

    def spend_on_answer(self, size: int) -> None:
        """`size` bytes of those that are sent are an answer."""
        self._answers_left = max(self._answers_left - size, -_ANSWERS_AT_ONCE)

    def spend_on_acknowledgement(self, size: int) -> None:
        """`size` bytes of those that are sent acknowledge a command."""
        self._acknowledgements_left -= size

    def spend_on_text(self, size: int) -> None:
        """`size` bytes of those that are sent are a text."""
        self._texts_left -= size

    def claim_room(self) -> bool:
        """True if telemetry may be sent; the caller then sends it."""
        if not self.rate or self._left > 0:
            return True
        self._earn()
        return self._spare.take()

    def is_crowded(self) -> bool:
        """True if the rate is unknown and answers take so much that telemetry should be sent half as often."""
        if self.rate or self._answers_left >= _CROWDED:
            return False
        self._earn()
        return self._answers_left < _CROWDED

    def claim_answer_room(self) -> bool:
        """True if an answer may be sent; the caller then sends it."""
        self._earn()
        if self._answers_left > 0 and self._has_line_room():
            return True
        return self.rate > 0 and self._answers_spare.take()

    def claim_acknowledgement_room(self) -> bool:
        """True if an acknowledgement may be sent; the caller then sends it."""
        self._earn()
        return self._acknowledgements_left > 0 and self._has_turn(self._acknowledgements_spare)

    def claim_text_room(self) -> bool:
        """True if a text may be sent; the caller then sends it."""
        self._earn()
        return self._texts_left > 0 and self._has_turn(self._texts_spare)

    def longest(self) -> int:
        """Maximum size in bytes of a frame that can be split, so that steering waits no longer than 16 ms."""
        return self.rate >> 6 if self.rate else _MOST

    def _has_turn(self, spare: "_Spare") -> bool:
        """True if the line has room, or had none for a message of this kind for as long as `spare` says."""
        if self._has_line_room():
            spare.restart()
            return True
        return spare.take()

    def _has_line_room(self) -> bool:
        return not self.rate or self._left > self.rate >> 7  # 8 ms: some answers are two frames

    def hear_radio(self, free: int) -> None:
        """A RADIO_STATUS reports `free` percent of the radio's buffer; above 100 is unknown."""
        if free > 100 or (self._heard_us < _REPORT_US and self.rate):
            return
        self._heard_us = 0
        rate = self.rate or max(self._measured, _LEAST)
        if free < _LOW:
            rate = rate * 3 // 5
        elif free < _SCARCE:
            rate = rate * 7 // 8
        elif free > _PLENTY:
            rate = rate * 5 // 4 if self.rate else 0
        elif not self.rate:
            rate = 0
        limit = self._most or _MOST
        self.rate = min(max(rate, _LEAST), limit) if rate else 0
        if not self._most and self.rate >= _MOST:
            self.rate = 0


class _Spare:
    """Lets one message through in `every_us` on a line that has no room; each kind of message has its own."""

    def __init__(self, every_us: int) -> None:
        self._every_us = every_us
        self._waited_us: int = 0

    def refill(self, elapsed_us: int) -> None:
        """Account for the time since the last call [us]."""
        self._waited_us = min(self._waited_us + elapsed_us, self._every_us)

    def restart(self) -> None:
        """A message was sent: the next one is not let through before its time."""
        self._waited_us = 0

    def take(self) -> bool:
        """True if a message may be sent now."""
        if self._waited_us < self._every_us:
            return False
        self._waited_us = 0
        return True


def _bytes_in(rate: int, elapsed_us: int) -> int:
    """What a link of `rate` [bytes/s] carries in `elapsed_us`, at most a second, in integers of 30 bits."""
    return (rate >> 2) * (elapsed_us >> 6) // 3906 if rate < 131072 else (rate >> 6) * (elapsed_us >> 4) // 977
