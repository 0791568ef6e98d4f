"""Bytes over UDP, for the PC (CPython and MicroPython's unix port)."""

import select
import socket


class UdpTransport:
    """Datagrams to and from one peer."""

    datagrams = True

    def __init__(self, host, port):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._peer = socket.getaddrinfo(host, port)[0][-1]
        self._poll = select.poll()
        self._poll.register(self._socket, select.POLLIN)

    def read(self):
        """One datagram, or None."""
        try:
            return self._socket.recv(2048)
        except OSError:  # nothing there, or the peer is gone
            return None

    def write(self, data):
        """Send `data` as one datagram; what cannot be sent is lost, as on any radio."""
        try:
            self._socket.sendto(data, self._peer)
        except OSError:
            pass

    def wait(self, timeout_ms):
        """Wait for a datagram; False if none came within `timeout_ms`."""
        return bool(self._poll.poll(timeout_ms))
