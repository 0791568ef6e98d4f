"""The link to a board: bytes to and from a serial port or a UDP peer, with reconnection."""

import socket
import time
from collections.abc import Callable
from typing import Any, Protocol

from sim_bridge.errors import ScenarioError
from sim_bridge.links.ground_path import parse_address

_RETRY_S = 1.0
_BITS_PER_BYTE = 10  # 8 data bits, start and stop


class Port(Protocol):
    """Bytes to and from a board. `bytes_per_s` is the link's capacity, 0 if unknown."""

    bytes_per_s: float

    def send(self, data: bytes) -> None:
        """Send `data`; lost if the board is not there."""
        ...

    def receive(self, timeout_s: float) -> bytes:
        """Bytes received within `timeout_s`, or b""."""
        ...

    def close(self) -> None:
        """Give the port back."""
        ...


def open_port(link: str, say: Callable[[str], None]) -> Port:
    """Open `serial:DEVICE:BAUD` or `udp:HOST:PORT`; `say` is told when a board is unplugged and when it is back.

    Raises:
        ScenarioError: `link` is neither, or cannot be opened.
    """
    kind, _, rest = link.partition(":")
    if kind == "serial":
        device, colon, baud = rest.rpartition(":")
        if colon and baud.isdigit() and device:
            return SerialPort(device, int(baud), say)
    elif kind == "udp":
        return UdpPort(parse_address(rest, f"--link {link}"), link)
    raise ScenarioError(f"--link {link}: must be serial:DEVICE:BAUD or udp:HOST:PORT, "
                        "such as serial:/dev/ttyACM0:115200")


class UdpPort:
    """A board that sends to an address of this computer (GROUND in its board.py); replies go to its sender address.

    Raises:
        ScenarioError: cannot listen at that address.
    """

    bytes_per_s = 0.0

    def __init__(self, address: tuple[str, int], link: str):
        self._peer: tuple[str, int] | None = None
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind(address)
        except OSError as error:
            self._socket.close()
            raise ScenarioError(f"--link {link}: {error.strerror}; give an address of this computer, "
                                "the one in GROUND of the board's board.py") from error

    def send(self, data: bytes) -> None:
        """See Port."""
        if self._peer:
            try:
                self._socket.sendto(data, self._peer)
            except OSError:
                return

    def receive(self, timeout_s: float) -> bytes:
        """See Port."""
        self._socket.settimeout(max(0.0, timeout_s))
        try:
            data, self._peer = self._socket.recvfrom(65536)
        except OSError:
            return b""
        return data

    def close(self) -> None:
        """See Port."""
        self._socket.close()


class SerialPort:
    """A board on a cable. When it is unplugged, this retries each second and never raises."""

    def __init__(self, device: str, baud: int, say: Callable[[str], None]):
        self.bytes_per_s = baud / _BITS_PER_BYTE
        self._device, self._baud, self._say = device, baud, say
        self._retry_at = 0.0
        self._serial: Any = self._open()

    def send(self, data: bytes) -> None:
        """See Port."""
        if self._ready():
            try:
                self._serial.write(data)
            except OSError as error:  # also pyserial's own
                self._lost(error)

    def receive(self, timeout_s: float) -> bytes:
        """See Port."""
        if not self._ready():
            time.sleep(max(0.0, timeout_s))
            return b""
        try:
            self._serial.timeout = max(0.0, timeout_s)
            return self._serial.read(max(1, self._serial.in_waiting))
        except (OSError, TypeError) as error:  # pyserial trips over a descriptor that has gone
            self._lost(error)
            return b""

    def close(self) -> None:
        """See Port."""
        if self._serial:
            self._serial.close()

    def _open(self) -> Any:
        import serial  # noqa: PLC0415  only where there is a cable

        try:
            return serial.Serial(self._device, self._baud, timeout=0, write_timeout=0.1)
        except (serial.SerialException, ValueError) as error:
            raise ScenarioError(f"{self._device}: {getattr(error, 'strerror', None) or error}") from error

    def _ready(self) -> bool:
        """True when the port is open; tries to open it again now and then."""
        if self._serial:
            return True
        if time.monotonic() >= self._retry_at:
            self._retry_at = time.monotonic() + _RETRY_S
            try:
                self._serial = self._open()
                self._say(f"{self._device} connected again")
            except ScenarioError:
                return False
        return bool(self._serial)

    def _lost(self, error: Exception) -> None:
        self._say(f"{self._device} disconnected ({error}): the board parks the kite; plug it in again, retrying")
        self._serial.close()
        self._serial = None
        self._retry_at = time.monotonic() + _RETRY_S
