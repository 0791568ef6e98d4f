"""Transports for bytes to and from a vehicle: UDP that listens, UDP that connects, a serial port."""

import errno
import socket
from typing import Protocol

import serial

from ground.errors import UsageError

_DATAGRAM = 65535
_FORMS = "udpin:HOST:PORT, udpout:HOST:PORT or serial:DEVICE:BAUD"


class LinkError(UsageError):
    """A link cannot be opened, or broke; the message is one line and names the link."""


class Transport(Protocol):
    """Carries bytes both ways. Only `receive` waits, so that tests can run in simulated time."""

    def send(self, data: bytes) -> None:
        """Send `data`, or drop it if there is no receiver. Raises LinkError if the link is broken."""
        ...

    def receive(self, timeout_s: float) -> bytes:
        """Wait up to `timeout_s` [s] for bytes; b"" on time-out. Raises LinkError if the link is broken."""
        ...

    @property
    def sender(self) -> object:
        """The sender of what `receive` last returned; None on links with a single peer."""
        ...

    def answer(self, sender: object) -> None:
        """From now on send only to `sender`, or to nobody if None. No effect on links with a single peer."""
        ...

    def fileno(self) -> int | None:
        """A descriptor that the operating system can wait for, or None."""
        ...

    def close(self) -> None:
        """Release the link. May be called twice."""
        ...


class OnePeer:
    """Shared by transports with a single peer."""

    sender: object = None

    def answer(self, sender: object) -> None:
        """See Transport."""


class _Udp(OnePeer):
    """Shared by both UDP transports."""

    def __init__(self, link: str, family: int) -> None:
        self._link = link
        self._socket = socket.socket(family, socket.SOCK_DGRAM)

    def send(self, data: bytes) -> None:
        try:
            self._transmit(data)
        except (ConnectionError, BlockingIOError):
            pass  # nobody listens yet, or no room: treated as lost
        except OSError as error:
            raise LinkError(f"link {self._link}: cannot send: {error.strerror or error}") from None

    def receive(self, timeout_s: float) -> bytes:
        self._socket.settimeout(max(timeout_s, 0.0))
        try:
            data, sender = self._socket.recvfrom(_DATAGRAM)
        except (TimeoutError, BlockingIOError, ConnectionError):
            return b""
        except OSError as error:
            raise LinkError(f"link {self._link}: cannot receive: {error.strerror or error}") from None
        self._heard(sender)
        return data

    def fileno(self) -> int | None:
        return self._socket.fileno()

    def close(self) -> None:
        self._socket.close()

    def _transmit(self, data: bytes) -> None:
        self._socket.send(data)

    def _heard(self, sender: tuple) -> None:
        """Note the sender of the last datagram."""


class UdpInTransport(_Udp):
    """Listens on an address; sends to the last sender, or to the one chosen by `answer`."""

    def __init__(self, link: str, family: int, address: tuple) -> None:
        super().__init__(link, family)
        self._peer: object = None
        self._chosen = False
        try:
            self._socket.bind(address)
        except OSError as error:
            self._socket.close()
            hint = error.strerror
            if error.errno == errno.EADDRINUSE:
                hint = "another program is listening there: stop it, or give another --link"
            raise LinkError(f"link {link}: cannot listen on port {address[1]}: {hint}") from None

    def _transmit(self, data: bytes) -> None:
        if isinstance(self._peer, tuple):
            self._socket.sendto(data, self._peer)

    def answer(self, sender: object) -> None:
        """See Transport."""
        self._peer, self._chosen = sender, True

    def _heard(self, sender: tuple) -> None:
        self.sender = sender
        if not self._chosen:
            self._peer = sender


class UdpOutTransport(_Udp):
    """Sends to an address, and receives from it alone."""

    def __init__(self, link: str, family: int, address: tuple) -> None:
        super().__init__(link, family)
        try:
            self._socket.connect(address)
        except OSError as error:
            self._socket.close()
            raise LinkError(f"link {link}: cannot send there: {error.strerror}") from None


class SerialTransport(OnePeer):
    """A serial port, 8N1, opened exclusively."""

    def __init__(self, link: str, device: str, baud: int) -> None:
        self._link = link
        try:
            self._port = serial.Serial(device, baud, write_timeout=1.0, exclusive=True)
        except (OSError, ValueError) as error:
            raise LinkError(f"link {link}: {_why_not_opened(device, error)}") from None

    def send(self, data: bytes) -> None:
        try:
            self._port.write(data)
        except serial.SerialTimeoutException:
            pass  # the port accepts nothing at present: treated as lost
        except OSError as error:
            raise LinkError(f"link {self._link}: serial port disconnected ({error})") from None

    def receive(self, timeout_s: float) -> bytes:
        try:
            self._port.timeout = max(timeout_s, 0.0)
            first = self._port.read(1)
            return first + self._port.read(self._port.in_waiting) if first else b""
        except OSError as error:
            raise LinkError(f"link {self._link}: serial port disconnected ({error})") from None

    def fileno(self) -> int | None:
        try:
            return self._port.fileno()
        except (OSError, AttributeError):  # Windows cannot wait for a port and a socket at once
            return None

    def close(self) -> None:
        self._port.close()


def open_transport(link: str) -> Transport:
    """Open `link`: udpin:HOST:PORT, udpout:HOST:PORT or serial:DEVICE:BAUD.

    Raises:
        LinkError: it has none of these forms, or the port, host or device is not available.
    """
    kind, place, number = parse_link(link)
    if kind == "serial":
        return SerialTransport(link, place, number)
    family, address = _resolve(link, place.strip("[]"), number)
    return (UdpInTransport if kind == "udpin" else UdpOutTransport)(link, family, address)


def parse_link(link: str) -> tuple[str, str, int]:
    """Kind, host or device, and port or baud rate of `link`. Raises LinkError if it has none of the forms."""
    kind, _, rest = link.partition(":")
    place, _, number = rest.rpartition(":")
    if kind not in ("udpin", "udpout", "serial") or not place or not number:
        raise LinkError(f"link {link!r}: must be {_FORMS}, such as udpin:127.0.0.1:14550")
    what, greatest = ("baud rate", 10_000_000) if kind == "serial" else ("port", 65535)
    if not number.isascii() or not number.isdigit() or not 1 <= int(number) <= greatest:
        raise LinkError(f"link {link!r}: {number!r} is not a {what}: must be a number from 1 to {greatest}")
    return kind, place, int(number)


def _resolve(link: str, host: str, port: int) -> tuple[int, tuple]:
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
    except (OSError, UnicodeError):
        raise LinkError(f"link {link!r}: unknown host {host!r}: must be a name or an address") from None
    return family, address


def _why_not_opened(device: str, error: Exception) -> str:
    from serial.tools import list_ports  # noqa: PLC0415  (scans the system's devices; only for this message)

    number = error.errno if isinstance(error, OSError) else None
    if number == errno.EACCES:
        return f"no permission to open {device}: join the group that owns it (often 'dialout')"
    if number in (errno.EAGAIN, errno.EBUSY):
        return f"{device} is in use by another program"
    reason = "no such device" if number == errno.ENOENT else f"cannot open {device}: {error}"
    found = ", ".join(sorted(port.device for port in list_ports.comports())) or "none"
    return f"{reason}; serial ports here: {found}"
