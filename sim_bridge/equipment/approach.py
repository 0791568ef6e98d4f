"""How a motor approaches its target, solved exactly: at a rate limit, by a first-order lag, or both.

The difference that is left falls at the rate limit while it is larger than rate times lag, and exponentially then.
"""

from math import exp, inf, log


class Approach:
    """Sizes are those of the difference between motor and target. At `stop`, if it is not 0, the motor stops."""

    def __init__(self, rate: float, lag: float, stop: float) -> None:
        self._rate = rate
        self._lag = lag
        self._stop = stop

    def size_after(self, size: float, dt: float) -> float:
        """What is left of `size` after `dt` [s]."""
        left = self._free_size_after(size, dt)
        return min(size, max(left, self._stop)) if self._stop else left

    def integral(self, size: float, dt: float) -> float:
        """Integral of what is left of `size` over the next `dt` [s]."""
        if self._stop:
            moving = self.time_until(size, self._stop)
            if moving < dt:
                return self._free_integral(size, moving) + min(size, self._stop) * (dt - moving)
        return self._free_integral(size, dt)

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

    def _free_size_after(self, size: float, dt: float) -> float:
        if self._rate:
            slow = self._rate * self._lag  # error below which the lag is slower than the rate limit
            if size > slow:
                ramp = min(dt, (size - slow) / self._rate)
                size -= self._rate * ramp
                dt -= ramp
        return size * exp(-dt / self._lag) if self._lag else (size if self._rate else 0.0)

    def _free_integral(self, size: float, dt: float) -> float:
        left = dt
        area = 0.0
        slow = self._rate * self._lag
        if self._rate and size > slow:
            ramp = min(dt, (size - slow) / self._rate)
            area = ramp * (size - 0.5 * self._rate * ramp)
            size -= self._rate * ramp
            left -= ramp
        if self._lag:
            area += size * self._lag * (1.0 - exp(-left / self._lag))
        return area
