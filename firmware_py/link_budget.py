"""How much telemetry the link carries: bytes a second, by the line's own speed and by what a radio tells of itself."""

_SECOND = 1000000
_REPORT_US = 500000  # a radio's reports are heeded this often at most: it takes a while until one shows an effect
_FORGET_US = 10000000  # a radio that has told nothing for this long is gone
_LEAST = 200  # bytes a second
_SPARE_US = 200000  # one message in this time is let through although there is no room: a list must come to its end
_MOST = 200000  # beyond it there is no limit to speak of
_LOW = 20  # [% of a radio's buffer left]: far too much is sent
_SCARCE = 50
_PLENTY = 90


class LinkBudget:
    """Counts the bytes sent against those that the link carries; integers only.

    `most` [bytes/s] is what the line carries, 0 where that is no limit. Whoever can wait asks `has_room` first;
    heartbeats, answers and steering are sent anyway and counted.
    """

    def __init__(self, most):
        self._most = most
        self.rate = most  # bytes a second at present, 0 for no limit
        self._left = 0
        self._spare_us = 0  # without room
        self._sent = 0
        self._measured = 0  # bytes of the last whole second
        self._second_us = 0
        self._heard_us = _FORGET_US  # since the last report heeded

    def refill(self, elapsed_us):
        """Account for the time since the last call [us]."""
        self._second_us += elapsed_us
        if self._second_us >= _SECOND:
            self._measured = self._sent
            self._second_us = self._sent = 0
        if self._heard_us < _FORGET_US:
            self._heard_us += elapsed_us
            if self._heard_us >= _FORGET_US:
                self.rate = self._most
        rate = self.rate
        if rate:
            earned = (rate >> 4) * (min(elapsed_us, _SECOND) >> 4) // 3906
            self._left = min(self._left + earned, rate >> 2)
            if self._spare_us < _SPARE_US:
                self._spare_us += elapsed_us

    def spend(self, size):
        """Account for `size` bytes that are sent."""
        self._sent += size
        if self.rate:
            self._left = max(self._left - size, -self.rate)

    def has_room(self):
        """True if what can wait need not; the asker sends then."""
        if not self.rate or self._left > 0:
            return True
        if self._spare_us < _SPARE_US:
            return False
        self._spare_us = 0
        return True

    def hear_radio(self, free):
        """A RADIO_STATUS says that `free` percent of the radio's buffer are left; beyond 100 it does not know."""
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
