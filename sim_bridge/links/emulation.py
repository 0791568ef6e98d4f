"""One direction of a radio link: delay, jitter, loss, duplicates, reordering, a byte rate; all from one seed."""

import heapq
from dataclasses import dataclass, replace
from math import inf
from random import Random
from typing import Any, NamedTuple

from kite_analysis.delay.effective_delay import whole_periods
from sim_bridge.settings import Settings, number

_LONGEST_QUEUE_S = 1.0  # what waits longer than this for its turn on a slow link is dropped
_BURSTS = 4.0  # of the mean length: one in fifty is longer
_USUAL_BURSTS_S = 1.0  # every preflight has time for these
_MOST_PATIENCE_S = 60.0


@dataclass(frozen=True, kw_only=True)
class LinkSettings(Settings):
    """Settings of one direction; the names are the scenario's keys."""

    delay_s: float = number(0.0, "one-way delay", 0.0, 30.0)
    jitter_s: float = number(0.0, "jitter of each direction, uniform, +-", 0.0, 10.0)
    loss: float = number(0.0, "fraction of frames lost, in each direction", 0.0, 1.0)
    loss_burst: float = number(0.0, "mean length of a loss burst in frames; up to 1: independent losses",
                               0.0, 1000.0)
    duplicate: float = number(0.0, "fraction of frames that arrive twice", 0.0, 1.0)
    reorder: float = number(0.0, "fraction of frames held back by reorder_s, so that others overtake them", 0.0, 1.0)
    reorder_s: float = number(0.1, "how long a held-back frame waits", 0.0, 10.0)
    rate_bytes_s: float = number(0.0, "capacity of the link in bytes per second; 0 is no limit", 0.0, 1e9)


class PathSettings(NamedTuple):
    """Both directions of a path: `down` towards the firmware, `up` from it."""

    down: LinkSettings = LinkSettings()
    up: LinkSettings = LinkSettings()

    @property
    def delay_s(self) -> float:
        """Delay there and back [s]."""
        return self.down.delay_s + self.up.delay_s


def without(path: PathSettings, delay_s: float, period_s: float) -> PathSettings:
    """`path` less `delay_s`, which something real takes already; no less than nothing is left.

    What is left on the way down is in whole periods, as the bridge sends samples once in each.
    """
    left = max(0.0, path.delay_s - delay_s)
    below = whole_periods(min(path.down.delay_s, left), period_s)
    return PathSettings(replace(path.down, delay_s=below), replace(path.up, delay_s=left - below))


def patience_s(settings: LinkSettings, size: int, period_s: float) -> float:
    """How long [s] to wait until items of `size` bytes, sent each `period_s`, come through: delay, queue, bursts."""
    wait_s = settings.delay_s + settings.jitter_s
    if settings.reorder:
        wait_s += settings.reorder_s
    if settings.rate_bytes_s:
        wait_s += min(_MOST_PATIENCE_S, _LONGEST_QUEUE_S + size / settings.rate_bytes_s)
    if settings.loss and settings.loss_burst > 1.0:
        wait_s += min(_MOST_PATIENCE_S, max(0.0, _BURSTS * settings.loss_burst * period_s - _USUAL_BURSTS_S))
    return wait_s


class LinkDirection:
    """Carries items from `send` to `due`, which returns each with the exact time at which it comes out."""

    def __init__(self, settings: LinkSettings, seed: str):
        self.settings = settings
        self.sent = 0
        self.lost = 0
        self._random = Random(seed)
        self._waiting: list[tuple[float, int, Any]] = []
        self._count = 0
        self._in_burst = False
        self._free_at = -inf  # preflight comes before t = 0
        self._plain = replace(settings, delay_s=0.0, reorder_s=0.1, loss_burst=0.0) == LinkSettings()

    def send(self, time_s: float, item: Any, size: int) -> None:
        """Put `item` of `size` bytes in at `time_s`."""
        self.sent += 1
        settings = self.settings
        if self._plain:
            self._push(time_s + settings.delay_s, item)
            return
        if settings.rate_bytes_s:
            start = max(time_s, self._free_at)
            if start - time_s > _LONGEST_QUEUE_S:
                self.lost += 1
                return
            self._free_at = start + size / settings.rate_bytes_s
            time_s = self._free_at
        if self._is_lost():
            self.lost += 1
            return
        copies = 2 if settings.duplicate and self._random.random() < settings.duplicate else 1
        for _ in range(copies):
            self._push(time_s + self._delay(), item)

    def due(self, until_s: float) -> list[tuple[float, Any]]:
        """Items that have arrived by `until_s`, with their times, earliest first."""
        items = []
        while self._waiting:
            time_s, _, item = self._waiting[0]
            if time_s > until_s + 1e-9:
                break
            heapq.heappop(self._waiting)
            items.append((time_s, item))
        return items

    def _push(self, time_s: float, item: Any) -> None:
        self._count += 1
        heapq.heappush(self._waiting, (time_s, self._count, item))

    def _delay(self) -> float:
        settings = self.settings
        delay = settings.delay_s
        if settings.jitter_s:
            delay = max(0.0, delay + self._random.uniform(-settings.jitter_s, settings.jitter_s))
        if settings.reorder and self._random.random() < settings.reorder:
            delay += settings.reorder_s
        return delay

    def _is_lost(self) -> bool:
        """Independent losses, or Gilbert-Elliott: bursts of mean length loss_burst, and `loss` of all frames lost."""
        settings = self.settings
        if not settings.loss:
            return False
        if settings.loss_burst <= 1.0 or settings.loss >= 1.0:
            return self._random.random() < settings.loss
        leave = 1.0 / settings.loss_burst
        enter = min(1.0, leave * settings.loss / (1.0 - settings.loss))
        self._in_burst = self._random.random() >= leave if self._in_burst else self._random.random() < enter
        return self._in_burst
