"""How the loop keeps its beat on a board's own clock: for telemetry, and so that none is armed that does not."""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

_BLOCK = 50  # type: Final  # ticks that are counted together
_MOST = 10  # type: Final  # of the last one to two blocks that may have been lost or too long


class Timing:
    """In lockstep nothing is noted, and all is 0."""

    def __init__(self) -> None:
        self.tick_us: int = 0  # the last tick took
        self.worst_us: int = 0  # the longest tick
        self.latest_us: int = 0  # the latest start of a tick after it was due
        self.overruns: int = 0  # ticks that took longer than a period, or began more than one late
        self._ticks: int = 0  # of the block that is being counted
        self._missed: int = 0  # overruns in it
        self._missed_before: int = 0  # in the block before it

    def note_start(self, late_us: int, period_us: int) -> bool:
        """A tick begins `late_us` after it was due; return False if that is no time at which it can be caught up.

        Then the loop stood still for more than a period, or its clock has jumped.
        """
        if 0 <= late_us <= period_us:
            if late_us > self.latest_us:
                self.latest_us = late_us
            return True
        self._miss()
        return False

    def note_end(self, tick_us: int, period_us: int) -> None:
        """The tick has taken `tick_us`."""
        self.tick_us = tick_us
        if tick_us > self.worst_us:
            self.worst_us = tick_us
        if tick_us > period_us:
            self._miss()
        self._ticks += 1
        if self._ticks >= _BLOCK:
            self._missed_before = self._missed
            self._ticks = self._missed = 0

    def problem(self) -> str | None:
        """Why the board is too slow for its rate, by its last ticks; None if it is not."""
        missed = self._missed + self._missed_before
        if missed <= _MOST:
            return None
        return "loop too slow: %d of %d ticks missed" % (missed, _BLOCK + self._ticks)

    def _miss(self) -> None:
        self.overruns += 1
        self._missed += 1
