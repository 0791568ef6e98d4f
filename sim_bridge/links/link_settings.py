"""Settings of radio links, and the delay and patience that follow from them."""

from dataclasses import dataclass, replace
from typing import NamedTuple

from kite_analysis.delay.whole_periods import whole_periods
from sim_bridge.settings import Settings, number

LONGEST_QUEUE_S = 1.0  # what waits longer than this for its turn on a slow link is dropped
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
        wait_s += min(_MOST_PATIENCE_S, LONGEST_QUEUE_S + size / settings.rate_bytes_s)
    if settings.loss and settings.loss_burst > 1.0:
        wait_s += min(_MOST_PATIENCE_S, max(0.0, _BURSTS * settings.loss_burst * period_s - _USUAL_BURSTS_S))
    return wait_s
