"""Link quality: message rate and loss."""

from collections import deque
from typing import NamedTuple

WINDOW_S = 5.0
_RESTART = 3  # this many consecutive old numbers: the sender has restarted its count


class _Came(NamedTuple):
    """The arrival of a message, and its change of the number lost."""

    time_s: float
    lost: int


class LinkStatistics:
    """Counts one vehicle's messages, and the gaps in its components' sequence numbers (which wrap at 256).

    `received`, `lost` and `repeated` count from the start; `rate_hz` and `loss` cover the last WINDOW_S seconds.
    """

    def __init__(self) -> None:
        self.received = 0
        self.lost = 0
        self.repeated = 0
        self.last_s: float | None = None
        self._first_s = 0.0
        self._numbers: dict[int, _Numbers] = {}
        self._recent: deque[_Came] = deque()

    def add(self, time_s: float, sequence: int, component: int = 1) -> int:
        """Count a message of `component` that arrived at `time_s` [s]; return by how many it was overtaken."""
        if self.last_s is None:
            self._first_s = time_s
        numbers = self._numbers.setdefault(component, _Numbers())
        lost = numbers.take(time_s, sequence)
        self.received += 1
        self.last_s = time_s
        if lost is None:
            self.repeated += 1
        else:
            self.lost += lost
        self._recent.append(_Came(time_s, lost or 0))
        self._forget(time_s)
        return numbers.overtaken(sequence)

    def rate_hz(self, now_s: float) -> float:
        """Messages per second [1/s], over WINDOW_S."""
        self._forget(now_s)
        return len(self._recent) / min(max(now_s - self._first_s, 1.0), WINDOW_S)

    def loss(self, now_s: float) -> float | None:
        """Fraction of messages lost over WINDOW_S; None if none arrived."""
        self._forget(now_s)
        lost = max(sum(came.lost for came in self._recent), 0)
        return lost / (lost + len(self._recent)) if self._recent else None

    def _forget(self, now_s: float) -> None:
        while self._recent and self._recent[0].time_s < now_s - WINDOW_S:
            self._recent.popleft()


class _Numbers:
    """Sequence numbers of one component."""

    def __init__(self) -> None:
        self._expected: int | None = None
        self._missing: set[int] = set()
        self._old_run, self._last_old = 0, -1
        self._last_s: float | None = None

    def take(self, time_s: float, sequence: int) -> int | None:
        """How many more are lost with this one; -1 if it had counted as lost itself; None for a repeated one."""
        if self._last_s is not None and time_s - self._last_s > WINDOW_S:
            self._restart()  # the numbers may have wrapped in the meantime
        self._last_s = time_s
        self._look_for_a_restart(sequence)
        ahead = 0 if self._expected is None else (sequence - self._expected) % 256
        if ahead < 128:
            self._missing |= {(sequence - back) % 256 for back in range(1, ahead + 1)}
            self._missing = {old for old in self._missing if 0 < (sequence - old) % 256 < 128}
            self._expected = (sequence + 1) % 256
            return ahead
        if sequence in self._missing:  # late, not lost
            self._missing.remove(sequence)
            return -1
        return None

    def overtaken(self, sequence: int) -> int:
        """By how many it was overtaken."""
        return 0 if self._expected is None else (self._expected - 1 - sequence) % 256

    def _look_for_a_restart(self, sequence: int) -> None:
        if self._expected is None or (sequence - self._expected) % 256 < 128:
            self._old_run = 0
            return
        self._old_run = self._old_run + 1 if sequence == (self._last_old + 1) % 256 else 1
        self._last_old = sequence
        if self._old_run >= _RESTART:
            self._restart()

    def _restart(self) -> None:
        self._expected, self._old_run = None, 0
        self._missing.clear()
