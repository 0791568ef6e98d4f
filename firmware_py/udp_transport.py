"""Bytes over UDP: on the PC (CPython and MicroPython's unix port) and on boards with Wi-Fi.

An address is whatever `getaddrinfo` makes of it: sockaddr bytes on the unix port, a tuple elsewhere.
"""

import select
import socket

_LONGEST = 2048


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
