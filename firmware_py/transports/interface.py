"""What the transports need of a board's hardware, for the types alone: no board has this file."""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Protocol

    from ..mavlink.interface import Data

    class Uart(Protocol):
        """A line, as MicroPython's machine.UART; never blocks."""

        def any(self) -> int:
            """How many bytes have arrived."""
            ...

        def readinto(self, __buffer: memoryview) -> int | None:
            """Fill the buffer; return the number of bytes, None for none."""
            ...

        def write(self, __data: Data) -> int | None:
            """Send what there is room for; return the number of bytes, None for none."""
            ...

    class Wlan(Protocol):
        """A network interface, as MicroPython's network.WLAN, made active."""

        def connect(self, __ssid: str, __key: str = ...) -> object:
            """Begin to join a network; OSError if busy with the try before."""
            ...

        def isconnected(self) -> bool:
            """True while there is a network."""
            ...

        def status(self) -> int:
            """Why there is none."""
            ...

        def ifconfig(self) -> tuple[str, str, str, str]:
            """Address, netmask, gateway, name server."""
            ...

    class Datagrams(Protocol):
        """Datagrams to and from ground stations: UdpStations."""

        @property
        def from_peer(self) -> bool:
            """True if the last datagram came from the configured peer."""
            ...

        def read(self) -> memoryview | None:
            """One datagram, or None."""
            ...

        def write(self, data: Data) -> None:
            """Send `data` as one datagram."""
            ...

        def wait(self, timeout_ms: int) -> bool:
            """Wait for a datagram; False if none came within `timeout_ms`."""
            ...
