"""The firmware's clock: microseconds that wrap at 2^30, on every platform."""

MASK = 0x3FFFFFFF
_HALF = 0x20000000


def ticks_add(ticks_us, delta_us):
    """`ticks_us` plus `delta_us` [us], wrapped."""
    return (ticks_us + delta_us) & MASK


def ticks_diff(later_us, earlier_us):
    """Signed time [us] from `earlier_us` to `later_us`; correct for spans below 2^29 us, about nine minutes."""
    return ((later_us - earlier_us + _HALF) & MASK) - _HALF


def ticks_since(later_us, earlier_us):
    """Time [us] from `earlier_us` to `later_us`, where that is known to be the later one: 0 to MASK."""
    return (later_us - earlier_us) & MASK
