"""Garbage collection in the idle time after a tick, never during one.

A tick leaves about 7 KB of garbage on a board. By default, MicroPython collects it when the heap is full, in the
middle of a tick; collecting every few ticks avoids that.
"""

import gc
import sys

from ..clock import ticks_diff

_MARGIN_US = 1000
_PATIENCE = 4  # rounds without enough slack after which it is done all the same


class Collector:
    """`worst_us` is the longest pause so far; `runs` counts them. On CPython it does nothing."""

    def __init__(self, ticks_us):
        self._ticks_us = ticks_us
        self._works = sys.implementation.name == "micropython"
        self._waited = 0
        self.worst_us = 0
        self.runs = 0

    def collect_if_due(self, every, slack_us):
        """At the end of a tick with `slack_us` left; `every` is the parameter COLLECT_TICKS, 0 for never."""
        if not every or not self._works:
            return
        self._waited += 1
        if self._waited < every:
            return
        if slack_us < self.worst_us + _MARGIN_US and self._waited < every * _PATIENCE:
            return
        self._waited = 0
        start = self._ticks_us()
        gc.collect()
        pause = ticks_diff(self._ticks_us(), start)
        self.worst_us = max(self.worst_us, pause)
        self.runs += 1
