"""A PC as the board: CPython, or MicroPython's unix port. Samples and steering go over the link."""

import time

from ..boards.file_storage import FileStorage
from ..clock import MASK, ticks_diff
from .interface import POWER_ON, NoLight, NoWatchdog


class UnixBoard:
    """Ends after `silence_ms` without data on its `transport`, so that no process is left behind.

    Parameters are kept in `storage_folder`, if one is given.
    """

    sensors = None
    actuator = None
    retained = None
    bytes_per_tick = 16384
    reset_cause = POWER_ON

    def __init__(self, transport, silence_ms, storage_folder=None):
        self.transport = self
        self.datagrams = transport.datagrams
        self.watchdog = NoWatchdog()
        self.light = NoLight()
        self.storage = None if storage_folder is None else FileStorage(storage_folder)
        self._transport = transport
        self._silence_us = silence_ms * 1000
        self._heard = self.ticks_us()

    def ticks_us(self):
        """The clock of the platform, in the firmware's wrap: MicroPython has ticks, CPython nanoseconds."""
        if hasattr(time, "ticks_us"):
            return getattr(time, "ticks_us")() & MASK  # noqa: B009  unknown to CPython's type stubs
        return time.monotonic_ns() // 1000 & MASK

    def ended(self):
        """True if nothing was received for too long."""
        return ticks_diff(self.ticks_us(), self._heard) > self._silence_us

    def read(self):
        """What has arrived, or None."""
        data = self._transport.read()
        if data:
            self._heard = self.ticks_us()
        return data

    def write(self, data):
        """Send `data`."""
        self._transport.write(data)

    @property
    def from_peer(self):
        """True if the last data came from the configured peer."""
        return getattr(self._transport, "from_peer", True)

    def wait(self, timeout_ms):
        """Wait for something to arrive; False if nothing came within `timeout_ms`."""
        return self._transport.wait(timeout_ms)
