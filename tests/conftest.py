"""What all tests share."""

import os
import signal


def pytest_configure() -> None:
    """Let Ctrl-C be Ctrl-C: a shell's background job ignores SIGINT, and so would every process started here.

    Everything is flown by the sources, also where `make compiled` has built the loop (test_native_loop.py has that).
    """
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.environ["KITEPILOT_LOOP"] = "interpreted"
