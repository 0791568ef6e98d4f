"""UDP over Wi-Fi: connects, and reconnects after a loss, without blocking the loop."""

from ..clock import MASK, ticks_diff

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Final

    from ..boards.interface import Clock
    from ..mavlink.interface import Data
    from .interface import Datagrams, Wlan

_LOOK_US = 250000  # type: Final  # between two looks at the network
_JOIN_US = 10000000  # type: Final  # a try to join is given this long before the next one


class WifiTransport:
    """Datagrams through `udp` (read, write, wait), on the network `ssid` that `wlan` joins.

    `key` is empty for an open network. `tell(text)` is called when the network comes or goes.
    """

    datagrams = True

    def __init__(
        self, wlan: "Wlan", ssid: str, key: str, udp: "Datagrams", ticks_us: "Clock", tell: "Callable[[str], None]"
    ) -> None:
        self._wlan = wlan
        self._ssid = ssid
        self._key = key
        self._udp = udp
        self._ticks_us = ticks_us
        self._tell = tell
        self._joined: bool = False
        self._looked: int = ticks_us()
        self._tried: int = ticks_us()
        self.received: int = 0
        self._join()

    @property
    def from_peer(self) -> bool:
        """True if the last data came from the configured peer."""
        return self._udp.from_peer

    def read(self) -> memoryview | None:
        """One datagram, or None."""
        data = self._udp.read()
        if data:
            self.received = (self.received + len(data)) & MASK
        return data

    def write(self, data: "Data") -> None:
        """Send `data` as one datagram; without a network it is lost. Called each tick; keeps the network connected."""
        now = self._ticks_us()
        if ticks_diff(now, self._looked) >= _LOOK_US:
            self._looked = now
            self._look(now)
        if self._joined:
            self._udp.write(data)

    def wait(self, timeout_ms: int) -> bool:
        """Wait for a datagram; False if none came within `timeout_ms`."""
        return self._udp.wait(timeout_ms)

    def _look(self, now: int) -> None:
        joined = self._wlan.isconnected()
        if joined != self._joined:
            self._joined = joined
            self._tried = now
            self._tell("Wi-Fi " + self._ssid + (": connected as " + self._wlan.ifconfig()[0] if joined else ": lost"))
        elif not joined and ticks_diff(now, self._tried) >= _JOIN_US:
            self._tried = now
            self._tell("Wi-Fi " + self._ssid + ": not connected (status %d), retrying" % self._wlan.status())
            self._join()

    def _join(self) -> None:
        """Begin to join; the network's own code goes on with it."""
        try:
            if self._key:
                self._wlan.connect(self._ssid, self._key)
            else:
                self._wlan.connect(self._ssid)
        except OSError as error:  # busy with the try before
            self._tell("Wi-Fi " + self._ssid + ": " + str(error))
