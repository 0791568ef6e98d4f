"""One direction of a radio link: delay, jitter, loss, duplicates, reordering, a byte rate; all from one seed."""

from dataclasses import replace
from math import inf
from random import Random
from typing import Any

from sim_bridge.links.link_settings import LONGEST_QUEUE_S, LinkSettings


class Parcel:
    """An `item` on its way, and the time at which it comes out [s]."""

    def __init__(self, time_s: float, item: Any) -> None:
        self.time_s = time_s
        self.item = item


class LinkDirection:
    """Carries items from `send` to `due`, which returns each with the exact time at which it comes out."""

    def __init__(self, settings: LinkSettings, seed: str):
        self.sent = 0
        self.lost = 0
        self._random = Random(seed)
        self._waiting: list[Parcel] = []  # earliest first; of those that come out together, the first that was sent
        self._in_burst = False
        self._free_at = -inf  # preflight comes before t = 0
        self.use(settings)

    def use(self, settings: LinkSettings) -> None:
        """Carry what is sent from now on as `settings` say."""
        self.settings = settings
        self._delay_s = settings.delay_s
        self._plain = replace(settings, delay_s=0.0, reorder_s=0.1, loss_burst=0.0) == LinkSettings()

    def send(self, time_s: float, item: Any, size: int) -> None:
        """Put `item` of `size` bytes in at `time_s`."""
        self.sent += 1
        if self._plain:
            time_s += self._delay_s
            waiting = self._waiting
            if waiting and waiting[-1].time_s > time_s:  # sent before the delay became shorter
                self._push(time_s, item)
            else:
                waiting.append(Parcel(time_s, item))
            return
        settings = self.settings
        if settings.rate_bytes_s:
            start = max(time_s, self._free_at)
            if start - time_s > LONGEST_QUEUE_S:
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

    def due(self, until_s: float) -> list[Parcel]:
        """What has arrived by `until_s`, earliest first."""
        parcels: list[Parcel] = []
        waiting = self._waiting
        while waiting and waiting[0].time_s <= until_s + 1e-9:
            parcels.append(waiting.pop(0))
        return parcels

    def _push(self, time_s: float, item: Any) -> None:
        waiting = self._waiting
        place = len(waiting)
        while place and waiting[place - 1].time_s > time_s:
            place -= 1
        waiting.insert(place, Parcel(time_s, item))

    def _delay(self) -> float:
        settings = self.settings
        delay: float = settings.delay_s
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
