"""The ground path: a UDP socket for ground stations, and the emulated ground link behind it."""

import socket
from typing import Protocol

from protocol.frame import MARKER_2
from sim_bridge.errors import ScenarioError
from sim_bridge.links.emulation import LinkDirection
from sim_bridge.links.ground_settings import GroundSettings
from sim_bridge.links.link_settings import PathSettings
from sim_bridge.links.wire import carries_control

_MOST_STATIONS = 32
_MOST_DATAGRAMS = 200  # taken in at one tick
_Address = tuple[str, int]


def parse_address(text: str, where: str) -> _Address:
    """HOST:PORT as an address.

    Raises:
        ScenarioError: it is not of that form.
    """
    host, colon, port = text.rpartition(":")
    if not colon or not host or not port.isdigit() or int(port) > 65535:
        raise ScenarioError(f"{where}: {text!r} is not HOST:PORT")
    return host, int(port)


class GroundPath(Protocol):
    """What carries datagrams between ground stations and the firmware."""

    def from_station(self, time_s: float, datagram: bytes) -> None:
        """A ground station sent `datagram`."""
        ...

    def to_firmware(self, time_s: float) -> list[bytes]:
        """Datagrams that have reached the firmware by `time_s`."""
        ...

    def from_firmware(self, time_s: float, frames: list[bytes]) -> None:
        """The firmware sent `frames`."""
        ...

    def to_stations(self, time_s: float) -> list[bytes]:
        """Frames that have come out on the ground by `time_s`."""
        ...


class GroundLink:
    """Both directions of the emulated ground path. Carries whole datagrams down and single frames up."""

    def __init__(self, path: PathSettings, seed: int):
        self._down = LinkDirection(path.down, f"{seed}:ground.down")
        self._up = LinkDirection(path.up, f"{seed}:ground.up")
        self.refused = 0

    def from_station(self, time_s: float, datagram: bytes) -> None:
        """A ground station sent `datagram`; what only the control side may send is refused."""
        if carries_control(datagram):
            self.refused += 1
        else:
            self._down.send(time_s, datagram, len(datagram))

    def to_firmware(self, time_s: float) -> list[bytes]:
        """Datagrams that have reached the firmware by `time_s`."""
        return [parcel.item for parcel in self._down.due(time_s)]

    def from_firmware(self, time_s: float, frames: list[bytes]) -> None:
        """The firmware sent `frames`."""
        for frame in frames:
            self._up.send(time_s, frame, len(frame))

    def to_stations(self, time_s: float) -> list[bytes]:
        """Frames that have come out on the ground by `time_s`."""
        return [parcel.item for parcel in self._up.due(time_s)]


class GroundSocket:
    """The ground stations: the address that the kite sends to, and those that have sent to ours.

    Up to 32 of the latter are sent to; a new one replaces the one that has been silent longest.

    Raises:
        ScenarioError: an address is invalid, or in use by another program.
    """

    def __init__(self, settings: GroundSettings):
        listen = parse_address(settings.listen, "ground.listen")
        self._configured = _resolved(settings.send_to)
        self._stations: dict[_Address, None] = {}  # the longest silent first
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        try:
            self._socket.bind(listen)
        except OSError as error:
            self._socket.close()
            raise ScenarioError(
                f"ground.listen = {settings.listen}: {error.strerror}; "
                "stop the other program or set ground.listen to another port") from error
        self.address: _Address = self._socket.getsockname()

    def receive(self) -> list[bytes]:
        """Datagrams that have come since the last call, up to a fixed number."""
        datagrams: list[bytes] = []
        while len(datagrams) < _MOST_DATAGRAMS:
            try:
                datagram, peer = self._socket.recvfrom(65536)
            except BlockingIOError:
                break
            except OSError:  # an earlier datagram found nobody
                continue
            self._hear(peer, datagram)
            datagrams.append(datagram[:1400])
        return datagrams

    def send(self, frames: list[bytes]) -> None:
        """Send each frame to every ground station; one that is not there is no error."""
        stations = [self._configured, *self._stations]
        for frame in frames:
            for peer in stations:
                try:
                    self._socket.sendto(frame, peer)
                except OSError:
                    continue

    def close(self) -> None:
        """Give the port back."""
        self._socket.close()

    def _hear(self, peer: _Address, datagram: bytes) -> None:
        """Note who speaks; a stranger is a station if that is MAVLink."""
        known = peer in self._stations
        if peer == self._configured or not (known or datagram[:1] == bytes([MARKER_2])):
            return
        if known:
            del self._stations[peer]
        elif len(self._stations) >= _MOST_STATIONS:
            del self._stations[next(iter(self._stations))]
        self._stations[peer] = None


def _resolved(text: str) -> _Address:
    """Where ground stations are sent to, as a number: that is how they are known when they answer."""
    host, port = parse_address(text, "ground.send_to")
    try:
        return socket.gethostbyname(host), port
    except OSError as error:
        raise ScenarioError(f"ground.send_to = {text}: unknown host {host} ({error.strerror})") from error
