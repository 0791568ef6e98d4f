"""Bytes over UDP: on the PC (CPython and MicroPython's unix port) and on boards with Wi-Fi.

An address is whatever `getaddrinfo` makes of it: sockaddr bytes on the unix port, a tuple elsewhere.
"""

import select
import socket

from ..clock import ticks_diff

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any, Final, TypeAlias

    from ..boards.interface import Clock
    from ..mavlink.interface import Data

    Address: TypeAlias = Any

_LONGEST = 2048  # type: Final
_OTHERS = 3  # type: Final  # ground stations beside the one that is configured: each costs a board 0.2 ms a tick
_SILENT_US = 5000000  # type: Final  # five heartbeats of a ground station: after that it gives way to a new one


class UdpTransport:
    """Datagrams to and from one peer; those of others are ignored."""

    datagrams = True
    from_peer = True  # the last datagram came from the peer that is configured

    def __init__(self, host: str, port: int) -> None:
        self._socket: "socket.socket" = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._peer: "Address" = _resolve(host, port)
        self._poll: "select.poll" = select.poll()
        self._poll.register(self._socket, select.POLLIN)
        self._socket.connect(self._peer)
        self._buffer: bytearray = bytearray(_LONGEST)  # made once: a fresh one a tick would shred the heap of a board
        self._view: memoryview = memoryview(self._buffer)
        self._read_into: "Callable[[bytearray], int]" = (
            getattr(self._socket, "readinto", None) or self._socket.recv_into)  # the first is MicroPython's

    def read(self) -> memoryview | None:
        """One datagram, or None; valid until the next call."""
        try:
            size = self._read_into(self._buffer)
        except OSError:  # nothing there, or the peer is gone
            return None
        return self._view[:size] if size else None

    def write(self, data: "Data") -> None:
        """Send `data` as one datagram; what cannot be sent is lost, as on any radio."""
        try:
            self._socket.send(data)
        except OSError:
            pass

    def wait(self, timeout_ms: int) -> bool:
        """Wait for a datagram; False if none came within `timeout_ms`."""
        return bool(self._poll.poll(timeout_ms))


class _Station:
    """Who else is sent to: `heard` is when they last sent something [us, wrapped], None for over _SILENT_US ago."""

    def __init__(self, address: "Address", heard: int | None) -> None:
        self.address = address
        self.heard = heard


class UdpStations:
    """Datagrams to and from several ground stations: the one at `host`, and up to _OTHERS that have sent something.

    A station that keeps sending keeps its place; one that has been silent for five seconds is replaced by a new one.
    `from_peer` tells whether the last datagram came from `host` and `port` themselves. The socket takes the same number
    for its own port, where that is free, so that others find it.
    """

    datagrams = True

    def __init__(self, host: str, port: int, ticks_us: "Clock") -> None:
        self.from_peer: bool = False
        self._ticks_us = ticks_us
        self._socket: "socket.socket" = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._peer: "Address" = _resolve(host, port)
        self._poll: "select.poll" = select.poll()
        self._poll.register(self._socket, select.POLLIN)
        self._others: "list[_Station]" = []  # the one heard last at the end
        try:
            self._socket.bind(_resolve("0.0.0.0", port))
        except OSError:  # taken, on a PC
            pass

    def read(self) -> memoryview | None:
        """One datagram, or None; from now on its sender is sent to, if there is a place."""
        try:
            data, sender = self._socket.recvfrom(_LONGEST)
        except OSError:
            return None
        self.from_peer = sender == self._peer
        if not self.from_peer:
            self._hear(sender)
        return memoryview(data) if data else None

    def write(self, data: "Data") -> None:
        """Send `data` to each of them. Called each tick, so their silence is looked at."""
        self._send(data, self._peer)
        now = self._ticks_us()
        for station in self._others:
            heard = station.heard
            if heard is not None and ticks_diff(now, heard) > _SILENT_US:
                station.heard = None  # noted while the clock has not wrapped
            self._send(data, station.address)

    def wait(self, timeout_ms: int) -> bool:
        """Wait for a datagram; False if none came within `timeout_ms`."""
        return bool(self._poll.poll(timeout_ms))

    def _hear(self, sender: "Address") -> None:
        """Keep a station's place, or give it one if there is any; the longest silent one gives way first."""
        others = self._others
        for index in range(len(others)):
            if others[index].address == sender:
                station = others.pop(index)
                station.heard = self._ticks_us()
                others.append(station)
                return
        if len(others) >= _OTHERS:
            if others[0].heard is not None:
                return
            others.pop(0)
        others.append(_Station(sender, self._ticks_us()))

    def _send(self, data: "Data", address: "Address") -> None:
        try:
            self._socket.sendto(data, address)
        except OSError:
            pass


def _resolve(host: str, port: int) -> "Address":
    """The address of a port, as sockets take it."""
    for _, _, _, _, address in socket.getaddrinfo(host, port):
        return address
    raise OSError
