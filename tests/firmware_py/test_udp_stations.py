"""A board on a network: whoever sends it something is answered too, and the one heard least recently gives way."""

import socket

from firmware_py.udp_transport import UdpStations


def station() -> socket.socket:
    """A ground station's socket, on a port of its own."""
    one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    one.bind(("127.0.0.1", 0))
    one.settimeout(5.0)
    return one


def test_the_configured_station_and_the_last_three_others_hear_everything():
    configured, *others = (station() for _ in range(6))
    board = UdpStations("127.0.0.1", configured.getsockname()[1])
    board.write(b"first")
    data, address = configured.recvfrom(100)
    assert data == b"first"
    for one in others:
        one.sendto(b"hello", address)
        assert board.wait(5000)
        assert board.read() == b"hello"
    others[2].sendto(b"again", address)  # it was the eldest but one of three
    assert board.wait(5000)
    assert board.read() == b"again"
    assert board.read() is None
    late = station()
    late.sendto(b"late", address)
    assert board.wait(5000)
    assert board.read() == b"late"
    board.write(b"to all")
    for one in (configured, others[2], others[4], late):
        assert one.recv(100) == b"to all"
    for one in (others[0], others[1], others[3]):
        one.setblocking(False)
        try:
            raise AssertionError(one.recv(100))
        except BlockingIOError:
            pass
    for one in (configured, late, *others):
        one.close()
