"""How a motor approaches its target, solved exactly: at a rate limit, by a first-order lag, or both.

The difference that is left falls at the rate limit while it is larger than rate times lag, and exponentially then.
"""

from math import exp, inf, log


class Approach:
    """Sizes are those of the difference between motor and target. At `stop`, if it is not 0, the motor stops.

    After `go`, `left` is what is left of the size, and `area` its integral over the time.
    """

    def __init__(self, rate: float, lag: float, stop: float) -> None:
        self._rate = rate
        self._lag = lag
        self._stop = stop
        self.left = 0.0
        self.area = 0.0

    def go(self, size: float, dt: float) -> None:
        """Go on from `size` for `dt` [s]."""
        self._go_freely(size, dt)
        stop = self._stop
        if not stop:
            return
        left = min(size, max(self.left, stop))
        moving = self.time_until(size, stop)
        if moving < dt:
            self._go_freely(size, moving)
            self.area += min(size, stop) * (dt - moving)
        self.left = left

    def time_until(self, size: float, to: float) -> float:
        """How long it takes from `size` to the size `to` [s]; infinity if that is never reached."""
        if to >= size:
            return 0.0
        if to < self._stop or to <= 0.0:
            return inf
        time = 0.0
        slow = self._rate * self._lag
        if self._rate and size > slow:
            end = max(to, slow)
            time = (size - end) / self._rate
            size = end
        return time + self._lag * log(size / to) if size > to else time

    def _go_freely(self, size: float, dt: float) -> None:
        """As `go`, of a motor that never stops."""
        rate = self._rate
        lag = self._lag
        area = 0.0
        slow = rate * lag  # error below which the lag is slower than the rate limit
        if rate and size > slow:
            to_slow = (size - slow) / rate
            ramp = to_slow if to_slow < dt else dt
            area = ramp * (size - 0.5 * rate * ramp)
            size -= rate * ramp
            dt -= ramp
        if lag:
            kept = exp(-dt / lag)
            area += size * lag * (1.0 - kept)
            size *= kept
        elif not rate:
            size = 0.0
        self.left = size
        self.area = area
