"""The firmware's clock: microseconds that wrap at 2^30, on every platform."""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

MASK = 0x3FFFFFFF  # type: Final
_HALF = 0x20000000  # type: Final


def ticks_add(ticks_us: int, delta_us: int) -> int:
    """`ticks_us` plus `delta_us` [us], wrapped."""
    return (ticks_us + delta_us) & MASK


def ticks_diff(later_us: int, earlier_us: int) -> int:
    """Signed time [us] from `earlier_us` to `later_us`; correct for spans below 2^29 us, about nine minutes."""
    return ((later_us - earlier_us + _HALF) & MASK) - _HALF


def ticks_since(later_us: int, earlier_us: int) -> int:
    """Time [us] from `earlier_us` to `later_us`, where that is known to be the later one: 0 to MASK."""
    return (later_us - earlier_us) & MASK
