"""The transports over real sockets and a real pseudo-terminal."""

import os
import socket
import time
from contextlib import closing

import pytest

from ground.link.connection import Connection
from ground.link.links import open_links
from ground.link.transports import LinkError, open_transport
from protocol import dialect

HOST = "127.0.0.1"
LONG_S = 30.0  # never waited for where things work


@pytest.fixture
def vehicle():
    """A plain UDP socket on a port of its own."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as plain:
        plain.bind((HOST, 0))
        plain.settimeout(LONG_S)
        yield plain


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as plain:
        plain.bind((HOST, 0))
        return plain.getsockname()[1]


def test_udpin_answers_whoever_was_heard_last(vehicle):
    port = free_port()
    with closing(open_transport(f"udpin:{HOST}:{port}")) as transport:
        transport.send(b"to nobody")
        assert transport.receive(0.0) == b""
        vehicle.sendto(b"first", (HOST, port))
        assert transport.receive(LONG_S) == b"first"
        transport.send(b"answer")
        assert vehicle.recv(100) == b"answer"
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.settimeout(LONG_S)
            other.sendto(b"second", (HOST, port))
            assert transport.receive(LONG_S) == b"second"
            transport.send(b"to the other")
            assert other.recv(100) == b"to the other"


def test_a_station_on_udpin_answers_where_the_kites_heartbeat_comes_from(vehicle):
    """Two strangers talk more than the kite, one of them under its id: both get nothing. A kite that moves is followed,
    but not while the first one is heard."""
    port, clock = free_port(), [0.0]
    links = open_links([f"udpin:{HOST}:{port}"], lambda: clock[0], print)
    connection = Connection(links)
    beat = dialect.MAVLink_heartbeat_message(
        dialect.MAV_TYPE_KITE, dialect.MAV_AUTOPILOT_GENERIC, 0, 0, dialect.MAV_STATE_ACTIVE, 3)
    packer = dialect.MAVLink(None, 1, 1)

    def hear(sender: socket.socket, data: bytes) -> None:
        packer.seq = (packer.seq + 1) % 256
        sender.sendto(data or beat.pack(packer), (HOST, port))
        connection.poll(LONG_S)

    with closing(links), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger, \
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as impostor:
        for other in (stranger, impostor):
            other.bind((HOST, 0))
            other.setblocking(False)
        hear(stranger, b"not MAVLink at all")
        hear(vehicle, b"")
        hear(stranger, b"again")
        hear(impostor, b"")
        connection.send(dialect.MAVLink_param_request_list_message(1, 1))
        kinds = set()
        while "PARAM_REQUEST_LIST" not in kinds:
            kinds |= {message.get_type() for message in dialect.MAVLink(None).parse_buffer(vehicle.recv(2000)) or []}
        for other in (stranger, impostor):
            with pytest.raises(BlockingIOError):
                other.recv(2000)
        clock[0] += 10.0
        hear(impostor, b"")
        connection.send(dialect.MAVLink_param_request_list_message(1, 1))
        impostor.settimeout(LONG_S)
        assert impostor.recv(2000)


def test_udpout_calls_and_hears_the_answer(vehicle):
    with closing(open_transport(f"udpout:{HOST}:{vehicle.getsockname()[1]}")) as transport:
        transport.send(b"hello")
        data, caller = vehicle.recvfrom(100)
        vehicle.sendto(b"answer", caller)
        assert (data, transport.receive(LONG_S)) == (b"hello", b"answer")


def test_udpout_to_a_port_where_nobody_listens_just_hears_nothing():
    with closing(open_transport(f"udpout:{HOST}:{free_port()}")) as transport:
        for _ in range(3):
            transport.send(b"anybody there?")
            assert transport.receive(0.01) == b""


def test_a_serial_port_carries_bytes_both_ways_and_says_when_it_is_gone():
    board, port = os.openpty()
    link = f"serial:{os.ttyname(port)}:57600"
    transport = open_transport(link)
    assert transport.receive(0.0) == b""
    os.write(board, bytes(range(256)))
    received = b""
    while len(received) < 256:
        received += transport.receive(LONG_S)
    assert received == bytes(range(256))
    transport.send(b"\x00\x11\x13\r\n\xfd")
    assert os.read(board, 100) == b"\x00\x11\x13\r\n\xfd"
    with pytest.raises(LinkError, match="in use by another program"):
        open_transport(link)
    os.close(port)
    os.close(board)
    with pytest.raises(LinkError, match=f"^link {link}: serial port disconnected"):
        transport.receive(LONG_S)
    transport.close()


def test_a_port_that_is_taken_is_named(vehicle):
    port = vehicle.getsockname()[1]
    with pytest.raises(LinkError, match=f"port {port}: another program is listening there"):
        open_transport(f"udpin:{HOST}:{port}")


@pytest.mark.parametrize(("link", "said"), [
    ("", "must be udpin:HOST:PORT, udpout:HOST:PORT or serial:DEVICE:BAUD"),
    ("udp:127.0.0.1:14550", "must be udpin"),
    ("udpin:127.0.0.1", "must be udpin"),
    ("udpin:127.0.0.1:http", "'http' is not a port: must be a number from 1 to 65535"),
    ("udpout:127.0.0.1:70000", "'70000' is not a port"),
    ("udpin:127.0.0.1:0", "'0' is not a port"),
    ("udpin:no.such.host.invalid:14550", "unknown host 'no.such.host.invalid'"),
    ("udpin:192.0.2.1:14550", "cannot listen on port 14550"),
    ("serial:/dev/ttyS0:fast", "'fast' is not a baud rate"),
    ("serial:/dev/no_such_port:57600", "no such device; serial ports here: "),
])
def test_a_link_that_cannot_be_is_answered_in_one_line(link, said):
    with pytest.raises(LinkError) as caught:
        open_transport(link)
    assert said in str(caught.value) and link in str(caught.value) and "\n" not in str(caught.value)


def test_several_links_are_waited_for_together(vehicle):
    """Two sockets and a serial port: what comes over any of them ends the waiting, and says over which it came."""
    board, port = os.openpty()
    ports = [free_port(), free_port()]
    names = [*(f"udpin:{HOST}:{number}" for number in ports), f"serial:{os.ttyname(port)}:57600"]
    links = open_links(names, time.monotonic, print)
    heartbeat = dialect.MAVLink_heartbeat_message(0, 0, 0, 0, 0, 3).pack(dialect.MAVLink(None, 1, 1))
    for name, send in zip(names, (lambda: vehicle.sendto(heartbeat, (HOST, ports[0])),
                                  lambda: vehicle.sendto(heartbeat, (HOST, ports[1])),
                                  lambda: os.write(board, heartbeat)), strict=True):
        send()
        heard = []
        while not heard:
            heard = links.receive(LONG_S)
        assert [entry.link.name for entry in heard] == [name]
    links.close()
    os.close(port)
    os.close(board)


def test_links_that_cannot_be_had_do_not_keep_others_from_being_used(vehicle):
    told = []
    taken = f"udpin:{HOST}:{vehicle.getsockname()[1]}"
    links = open_links([taken, f"udpin:{HOST}:{free_port()}"], time.monotonic, told.append)
    assert len(told) == 1 and "another program is listening there" in told[0] and "retrying" in told[0]
    links.close()
    with pytest.raises(LinkError, match="another program is listening there"):
        open_links([taken], time.monotonic, told.append)
    with pytest.raises(LinkError, match="given twice"):
        open_links([taken, taken], time.monotonic, told.append)
