"""Round-trip times: for time-outs, and summarized with spread and loss for the user."""

from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

_KEPT_S = 300.0
_NEVER_S = 30.0  # later answers are not counted


class DelaySummary(NamedTuple):
    """Round trips within a time window [s]: median, 5 % and 95 % quantiles, number, and loss.

    `loss` is a fraction over both directions, or None if it is too early to tell.
    """

    median_s: float
    low_s: float
    high_s: float
    answers: int
    loss: float | None

    @property
    def spread_s(self) -> float:
        """Width of the band that holds 90 % of them [s]."""
        return self.high_s - self.low_s


@dataclass
class Question:
    """When it was sent [s], and the time that the answer took [s], or None before that."""

    sent_s: float
    taken_s: float | None = None


class RoundTrip:
    """Times questions and answers. `seconds` is smoothed as in TCP (RFC 6298), None until the first answer.

    An early retry costs one frame, a late one costs the user time: the initial variation is smaller than TCP's.
    """

    UNKNOWN_S = 1.0  # time-out before the first answer
    LEAST_S, GREATEST_S = 0.2, 6.0

    def __init__(self) -> None:
        self.seconds: float | None = None
        self._variation_s = 0.0
        self._asked: deque[Question] = deque()

    def ask(self, now_s: float) -> Question:
        """Note that a question leaves at `now_s`; hand what this returns to `answer`."""
        while self._asked and self._asked[0].sent_s < now_s - _KEPT_S:
            self._asked.popleft()
        question = Question(now_s)
        self._asked.append(question)
        return question

    def answer(self, question: Question, now_s: float) -> None:
        """Its answer arrived at `now_s`; further copies change nothing."""
        taken_s = now_s - question.sent_s
        if question.taken_s is None and taken_s < _NEVER_S:
            question.taken_s = taken_s
            self.add(taken_s)

    def add(self, seconds: float) -> None:
        """Add a measured round trip [s]."""
        if self.seconds is None:
            self.seconds, self._variation_s = seconds, seconds / 8.0
            return
        self._variation_s += (abs(seconds - self.seconds) - self._variation_s) / 4.0
        self.seconds += (seconds - self.seconds) / 8.0

    @property
    def timeout_s(self) -> float:
        """How long to wait for an answer before a retry [s]."""
        if self.seconds is None:
            return self.UNKNOWN_S
        margin_s = max(4.0 * self._variation_s, 0.2 * self.seconds, 0.1)
        return min(max(self.seconds + margin_s, self.LEAST_S), self.GREATEST_S)

    def summary(self, now_s: float, window_s: float) -> DelaySummary | None:
        """Summary of the questions of the last `window_s` [s]; None if none of them has been answered."""
        recent = [question for question in self._asked if question.sent_s >= now_s - window_s]
        taken = sorted(question.taken_s for question in recent if question.taken_s is not None)
        if not taken:
            return None
        due = [question.taken_s for question in recent
               if question.taken_s is not None or now_s - question.sent_s > self.timeout_s]
        loss = due.count(None) / len(due) if len(due) > 1 else None
        return DelaySummary(_quantile(taken, 0.5), _quantile(taken, 0.05), _quantile(taken, 0.95), len(taken), loss)

    def unanswered_since(self, now_s: float) -> float:
        """For how long [s] the questions since the last answer have been overdue."""
        oldest_s = now_s
        for question in reversed(self._asked):
            if question.taken_s is not None:
                break
            oldest_s = question.sent_s
        return max(now_s - oldest_s - self.timeout_s, 0.0)


def _quantile(ordered: list[float], share: float) -> float:
    """The quantile `share` of `ordered`, which is not empty, interpolated linearly."""
    at = share * (len(ordered) - 1)
    low = int(at)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (at - low) * (ordered[high] - ordered[low])
