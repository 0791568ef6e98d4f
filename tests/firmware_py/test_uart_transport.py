"""Frames over a simulated UART: whole, in pieces, and when there is no room."""

from simulated_hardware import SimulatedClock, SimulatedUart

from firmware_py.mavlink.encoder import Encoder
from firmware_py.mavlink.generated_messages import HEARTBEAT, PING
from firmware_py.mavlink.link import MavlinkLink
from firmware_py.services.inbox import Inbox
from firmware_py.transports.uart import UartTransport


def made(start_us: int = 0):
    uart, clock = SimulatedUart(), SimulatedClock(start_us)
    return UartTransport(uart, clock.ticks_us, clock.sleep_us), uart, clock


def ping(sequence: int) -> bytes:
    buffer = bytearray(300)
    return bytes(buffer[:_PINGS.encode(buffer, 0, PING, (7, sequence, 0, 0))])


_PINGS = Encoder(255, 190)


def test_nothing_there_is_none_and_a_burst_comes_in_chunks():
    transport, uart, _ = made()
    assert transport.read() is None and not transport.datagrams
    uart.incoming += bytes(range(256)) * 5
    pieces = []
    while (piece := transport.read()) is not None:
        pieces.append(bytes(piece))
    assert b"".join(pieces) == bytes(range(256)) * 5
    assert [len(piece) for piece in pieces] == [512, 512, 256]
    assert transport.received == 1280


def test_frames_that_arrive_in_pieces_reach_the_inbox_whole():
    transport, uart, _ = made()
    link, inbox = MavlinkLink(transport), Inbox()
    stream = b"".join(ping(number) for number in range(60))
    for start in range(0, len(stream), 7):
        uart.incoming += stream[start : start + 7]
        link.receive(inbox)
    pings = [request.values for request in inbox.questions.requests]
    assert [number for _, number, _, _ in pings] == list(range(60))
    assert link.counters() == (0, 0, 0, 0)


def test_what_finds_no_room_is_lost_and_counted_and_nobody_waits():
    transport, uart, clock = made()
    link = MavlinkLink(transport)
    link.send(HEARTBEAT, (0, 17, 0, 1, 3, 3))
    link.flush()
    whole = len(uart.outgoing)
    assert whole == 21 and transport.lost == 0
    uart.room = 10
    transport.write(bytes(25))
    uart.room = 0
    transport.write(bytes(3))
    assert (len(uart.outgoing) - whole, transport.lost, clock.now) == (10, 18, 0)


def test_waiting_ends_with_a_byte_or_with_the_time_whichever_is_first():
    for start_us in (0, (1 << 30) - 5_000):  # the clock may wrap meanwhile
        transport, uart, clock = made(start_us)
        assert not transport.wait(0) and clock.now == start_us
        assert not transport.wait(20)
        assert 20_000 <= clock.now - start_us < 20_300
        began = clock.now
        clock.on_sleep = lambda now, began=began, uart=uart: uart.incoming.extend(b"x") if now > began + 7_000 else None
        assert transport.wait(20)
        assert 7_000 < clock.now - began < 7_500
        assert transport.wait(0)
