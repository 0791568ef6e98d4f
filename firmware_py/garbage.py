"""Garbage on a board: when it is collected, and how to make that short.

MicroPython marks what is alive depth first, with a stack of 64 objects (MICROPY_ALLOC_GC_STACK_SIZE). If an object has
more neighbours than the stack has room for, it walks through everything that is alive once more. So the order counts:
`run_in_order` gives the collector a chain of the modules, each after those that it imports, and of the largest objects,
so that each adds little to what was marked before. On a Pico that halves the pause.
"""

import gc
import sys

from .clock import ticks_diff

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Final

    from .boards.interface import Clock

_MARGIN_US = 1000  # type: Final
_PATIENCE = 2  # type: Final  # times as many ticks, after which garbage is collected whatever the idle time
_PACKAGE = "firmware_py."  # type: Final


def run_in_order(call: "Callable[[], None]", objects: "tuple[object, ...]") -> None:
    """Run `call()` with a heap that is marked in order; `objects` are further large ones, after the modules.

    The local names of what `exec` runs are the first root that MicroPython marks: there is nothing but the chain.
    """
    from .generated_module_order import MODULES  # noqa: PLC0415  of no use afterwards

    chain: object = None
    for thing in reversed(objects):
        chain = (chain, thing)
    for name in reversed(MODULES.split()):
        module = sys.modules.get(_PACKAGE + name)
        if module is not None:
            chain = (chain, module)
    names: "dict[str, object]" = {}

    def begin() -> None:
        names.clear()
        names["chain"] = chain
        call()

    names["begin"] = begin
    exec("begin()", names)


class Collector:
    """Collects garbage in the idle time after a tick, never during one. On CPython it does nothing.

    A tick leaves about 7 KB of garbage on a board, which MicroPython would collect when the heap is full, in the middle
    of a tick. Where the idle time is shorter than a pause, the next tick begins late by what is missing (Timing counts
    that). `worst_us` is the longest pause so far; `runs` counts them.
    """

    def __init__(self, ticks_us: "Clock") -> None:
        self._ticks_us = ticks_us
        self._works: bool = sys.implementation.name == "micropython"
        self._waited: int = 0
        self.worst_us: int = 0
        self.runs: int = 0

    def collect_if_due(self, every: float, left_us: int) -> None:
        """At the end of a tick with `left_us` left; `every` is the parameter COLLECT_TICKS, 0 for never."""
        if not every or not self._works:
            return
        self._waited += 1
        if self._waited < every:
            return
        if left_us < self.worst_us + _MARGIN_US and self._waited < every * _PATIENCE:
            return
        self._waited = 0
        start = self._ticks_us()
        gc.collect()
        elapsed_us = ticks_diff(self._ticks_us(), start)
        self.worst_us = max(self.worst_us, elapsed_us)
        self.runs += 1
