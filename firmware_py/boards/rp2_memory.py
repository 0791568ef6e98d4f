"""Memory of an RP2040 or RP2350 that outlives a reset: a block in Python's own heap, found again by its address.

MicroPython's linker scripts for the two leave no RAM unused: what is neither data nor heap is the stack of core 0, the
bank SCRATCH_X too. But a reset clears only .bss and sets only .data, and a start fills the heap from its bottom. So the
block lies well above the bottom: `start` imports this before anything large. The garbage collector knows the block, and
nothing else is given its place. Its address is kept in a scratch register of the watchdog: 0 to 3 are for programs, the
boot ROM and the SDK use 4 to 7 (RP2040 datasheet 4.7.4, RP2350 datasheet 5.2.4).

The old block is copied before the new one is made, mostly in the same place. A reset within the millisecond that this
takes finds no header, and all is lost; the watchdog does not run yet.
"""

import sys

import machine
import uctypes

from .retained_layout import SIZE, take_over

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

_DISTANCE = 65536  # type: Final  # some 20 KB of heap are used before this is imported, and 110 KB after the start
_IS_RP2350 = "RP2350" in sys.implementation._machine  # type: Final
_RAM = 0x20000000  # type: Final
_RAM_END = 0x20080000 if _IS_RP2350 else 0x20040000  # type: Final
SCRATCH = (0x400D8000 if _IS_RP2350 else 0x40058000) + 0x0C  # type: Final  # the watchdog's eight registers


def _claim() -> bytearray:
    """The block, with what it held before the reset."""
    address = machine.mem32[SCRATCH]
    old = None
    if _RAM <= address <= _RAM_END - SIZE:
        old = bytes(uctypes.bytearray_at(address, SIZE))
    fillers = [bytearray(_DISTANCE)]
    block = bytearray(SIZE)
    while uctypes.addressof(block) < uctypes.addressof(fillers[0]):  # in a gap further down
        fillers.append(block)
        block = bytearray(SIZE)
    take_over(block, old)
    machine.mem32[SCRATCH] = uctypes.addressof(block)
    return block


BLOCK = _claim()  # type: Final
