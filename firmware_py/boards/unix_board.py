"""A PC as the board: CPython, or MicroPython's unix port. Samples and steering go over the link."""

import time

from ..boards.file_storage import FileStorage
from ..clock import MASK, ticks_diff
from .interface import POWER_ON, NoLight, NoWatchdog

TYPE_CHECKING = False
if TYPE_CHECKING:
    from ..mavlink.interface import Data
    from .interface import BoardTransport


class UnixBoard:
    """Ends after `silence_ms` without data on its `transport`, so that no process is left behind.

    Parameters are kept in `storage_folder`, if one is given.
    """

    sensors = None
    actuator = None
    retained = None
    bytes_per_tick = 16384
    reset_cause = POWER_ON

    def __init__(self, transport: "BoardTransport", silence_ms: int, storage_folder: str | None = None) -> None:
        self.transport: "BoardTransport" = self
        self.datagrams: bool = transport.datagrams
        self.watchdog = NoWatchdog()
        self.light = NoLight()
        self.storage: "FileStorage | None" = None if storage_folder is None else FileStorage(storage_folder)
        self._transport = transport
        self._silence_us: int = silence_ms * 1000
        self._heard: int = self.ticks_us()

    def ticks_us(self) -> int:
        """The clock of the platform, in the firmware's wrap: MicroPython has ticks, CPython nanoseconds."""
        if hasattr(time, "ticks_us"):
            return getattr(time, "ticks_us")() & MASK  # noqa: B009  unknown to CPython's type stubs
        return time.monotonic_ns() // 1000 & MASK

    def ended(self) -> bool:
        """True if nothing was received for too long."""
        return ticks_diff(self.ticks_us(), self._heard) > self._silence_us

    def read(self) -> "Data | None":
        """What has arrived, or None."""
        data = self._transport.read()
        if data:
            self._heard = self.ticks_us()
        return data

    def write(self, data: memoryview) -> None:
        """Send `data`."""
        self._transport.write(data)

    @property
    def from_peer(self) -> bool:
        """True if the last data came from the configured peer."""
        return getattr(self._transport, "from_peer", True)

    def wait(self, timeout_ms: int) -> bool:
        """Wait for something to arrive; False if nothing came within `timeout_ms`."""
        return self._transport.wait(timeout_ms)
