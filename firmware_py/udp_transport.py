"""Bytes over UDP: on the PC (CPython and MicroPython's unix port) and on boards with Wi-Fi.

An address is whatever `getaddrinfo` makes of it: sockaddr bytes on the unix port, a tuple elsewhere.
"""

import select
import socket

_LONGEST = 2048
_OTHERS = 3  # ground stations beside the one that is configured: each costs a board 0.2 ms a tick


class UdpTransport:
    """Datagrams to and from one peer."""

    datagrams = True

    def __init__(self, host, port):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._peer = socket.getaddrinfo(host, port)[0][-1]
        self._poll = select.poll()
        self._poll.register(self._socket, select.POLLIN)
        self._buffer = bytearray(_LONGEST)  # made once: a fresh one a tick would shred the heap of a board
        self._view = memoryview(self._buffer)
        if hasattr(self._socket, "readinto"):  # MicroPython
            self._read_into = getattr(self._socket, "readinto")  # noqa: B009  unknown to CPython's type stubs
        else:
            self._read_into = self._socket.recv_into

    def read(self):
        """One datagram, or None; good until the next call."""
        try:
            size = self._read_into(self._buffer)
        except OSError:  # nothing there, or the peer is gone
            return None
        return self._view[:size] if size else None

    def write(self, data):
        """Send `data` as one datagram; what cannot be sent is lost, as on any radio."""
        try:
            self._socket.sendto(data, self._peer)
        except OSError:
            pass

    def wait(self, timeout_ms):
        """Wait for a datagram; False if none came within `timeout_ms`."""
        return bool(self._poll.poll(timeout_ms))


class UdpStations(UdpTransport):
    """Datagrams to and from several ground stations: the one at `host`, and whoever else sends something.

    The socket takes the same number for its own port, where that is free, so that others find it.
    """

    def __init__(self, host, port):
        super().__init__(host, port)
        self._others = []  # addresses, the one heard last at the end
        try:
            self._socket.bind(socket.getaddrinfo("0.0.0.0", port)[0][-1])
        except OSError:  # taken, on a PC
            pass

    def read(self):
        """One datagram, or None; its sender is sent to from now on."""
        try:
            data, sender = self._socket.recvfrom(_LONGEST)
        except OSError:
            return None
        if sender != self._peer:
            others = self._others
            if sender in others:
                if others[-1] != sender:
                    others.remove(sender)
                    others.append(sender)
            else:
                if len(others) >= _OTHERS:
                    others.pop(0)
                others.append(sender)
        return memoryview(data) if data else None

    def write(self, data):
        """Send `data` to each of them."""
        super().write(data)
        for other in self._others:
            try:
                self._socket.sendto(data, other)
            except OSError:
                pass
