"""The firmware's clock: microseconds that wrap at 2^30, on every platform."""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

MASK = 0x3FFFFFFF  # type: Final
HALF = 0x20000000  # type: Final  # what is further ahead lies behind


def ticks_add(ticks_us: int, delta_us: int) -> int:
    """`ticks_us` plus `delta_us` [us], wrapped."""
    return (ticks_us + delta_us) & MASK


def ticks_diff(later_us: int, earlier_us: int) -> int:
    """Signed time [us] from `earlier_us` to `later_us`; correct for spans below 2^29 us, about nine minutes.

    What every tick asks is written out where it is asked: a call takes a board 15 us.
    """
    return ((later_us - earlier_us + HALF) & MASK) - HALF
