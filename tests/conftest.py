"""What all tests share."""

import signal


def pytest_configure() -> None:
    """Let Ctrl-C be Ctrl-C: a shell's background job ignores SIGINT, and so would every process started here."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
