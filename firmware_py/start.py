"""Importing this starts the firmware; only /main.py on a board does."""

import gc
import sys

if hasattr(gc, "threshold"):  # what compiling leaves is collected as it goes, or the heap is in pieces afterwards
    getattr(gc, "threshold")(8192)  # noqa: B009  unknown to CPython's type stubs

if sys.platform == "rp2":  # before anything that fills the heap: see there
    from .boards import rp2_memory  # noqa: F401

from .startup import start

start(sys.platform)
