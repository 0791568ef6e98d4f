"""Bytes over a UART: a cable, or a pair of telemetry radios."""

from ..clock import MASK, ticks_diff

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Final

    from ..boards.interface import Clock
    from ..mavlink.interface import Data
    from .interface import Uart

_CHUNK = 512  # type: Final  # read at once [bytes]
_NAP_US = 200  # type: Final  # between two looks: two bytes at 115200 baud


class UartTransport:
    """A stream over `uart`, which has `any()`, `readinto(buffer)` and `write(data)`, and never blocks.

    `bytes_per_s` is the line's capacity, 0 if unlimited.
    `received` counts the bytes received, wrapped; `lost` those that could not be sent. A truncated frame is
    detected by its checksum, as on any radio.
    """

    datagrams = False

    def __init__(
        self, uart: "Uart", ticks_us: "Clock", sleep_us: "Callable[[int], object]", bytes_per_s: int = 0
    ) -> None:
        self.bytes_per_s = bytes_per_s
        self._uart = uart
        self._ticks_us = ticks_us
        self._sleep_us = sleep_us
        self._buffer: bytearray = bytearray(_CHUNK)
        self._view: memoryview = memoryview(self._buffer)
        self.received: int = 0
        self.lost: int = 0

    def read(self) -> memoryview | None:
        """What has arrived, or None; valid until the next call."""
        waiting = self._uart.any()
        if not waiting:
            return None
        size = self._uart.readinto(self._view[: min(waiting, _CHUNK)])
        if not size:
            return None
        self.received = (self.received + size) & MASK
        return self._view[:size]

    def write(self, data: "Data") -> None:
        """Send `data`, or what of it there is room for."""
        sent = self._uart.write(data) or 0  # None when there was no room at all
        if sent < len(data):
            self.lost = (self.lost + len(data) - sent) & MASK

    def wait(self, timeout_ms: int) -> bool:
        """Wait for a byte to arrive; False if none came within `timeout_ms`."""
        start = self._ticks_us()
        while not self._uart.any():
            if ticks_diff(self._ticks_us(), start) >= timeout_ms * 1000:
                return False
            self._sleep_us(_NAP_US)
        return True
