"""How good the link is: messages a second, messages lost, and how long an answer takes."""

from collections import deque

WINDOW_S = 5.0


class LinkStatistics:
    """Counts one sender's messages, and what is missing from their sequence numbers (which wrap at 256).

    `received`, `lost` and `repeated` count from the start; `rate_hz` and `loss` look back over WINDOW_S seconds.
    """

    def __init__(self) -> None:
        self.received = 0
        self.lost = 0
        self.repeated = 0
        self.last_s: float | None = None
        self._first_s = 0.0
        self._expected: int | None = None
        self._missing: set[int] = set()
        self._recent: deque[tuple[float, int]] = deque()  # time of a message, and the change in what is lost

    def add(self, time_s: float, sequence: int) -> None:
        """Take in a message that came at `time_s` [s] with this sequence number."""
        if self.last_s is None:
            self._first_s = time_s
        self.received += 1
        self.last_s = time_s
        lost = self._newly_lost(sequence)
        self.lost += lost
        self._recent.append((time_s, lost))
        self._forget(time_s)

    def rate_hz(self, now_s: float) -> float:
        """Messages a second of late, in 1/s."""
        self._forget(now_s)
        return len(self._recent) / min(max(now_s - self._first_s, 1.0), WINDOW_S)

    def loss(self, now_s: float) -> float | None:
        """Share of messages lost of late, 0 to 1; None when none came that could tell."""
        self._forget(now_s)
        lost = max(sum(change for _, change in self._recent), 0)
        return lost / (lost + len(self._recent)) if self._recent else None

    def _newly_lost(self, sequence: int) -> int:
        ahead = 0 if self._expected is None else (sequence - self._expected) % 256
        if ahead < 128:
            self._missing |= {(sequence - back) % 256 for back in range(1, ahead + 1)}
            self._missing = {old for old in self._missing if 0 < (sequence - old) % 256 < 128}
            self._expected = (sequence + 1) % 256
            return ahead
        if sequence in self._missing:  # late, not lost
            self._missing.remove(sequence)
            return -1
        self.repeated += 1
        return 0

    def _forget(self, now_s: float) -> None:
        while self._recent and self._recent[0][0] < now_s - WINDOW_S:
            self._recent.popleft()


class RoundTrip:
    """How long an answer takes, smoothed as TCP does (RFC 6298): `seconds` is None until the first was timed.

    Asking again too soon costs a frame, asking too late costs the user time: the first guess of the variation is
    smaller than TCP's.
    """

    UNKNOWN_S = 1.0  # a first guess for the time-out
    LEAST_S, GREATEST_S = 0.2, 6.0

    def __init__(self) -> None:
        self.seconds: float | None = None
        self._variation_s = 0.0

    def add(self, seconds: float) -> None:
        """Take in one measured answer time [s]."""
        if self.seconds is None:
            self.seconds, self._variation_s = seconds, seconds / 8.0
            return
        self._variation_s += (abs(seconds - self.seconds) - self._variation_s) / 4.0
        self.seconds += (seconds - self.seconds) / 8.0

    @property
    def timeout_s(self) -> float:
        """How long to wait for an answer before asking again [s]."""
        if self.seconds is None:
            return self.UNKNOWN_S
        margin_s = max(4.0 * self._variation_s, 0.2 * self.seconds, 0.1)
        return min(max(self.seconds + margin_s, self.LEAST_S), self.GREATEST_S)
