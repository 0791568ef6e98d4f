"""A board on a network: who is heard, who is answered, and whose samples are believed."""

import contextlib
import socket
from collections.abc import Iterator

import pytest
from firmware_bench import sample
from simulated_hardware import SimulatedClock

from firmware_py.mavlink.link import MavlinkLink
from firmware_py.services.inbox import Inbox
from firmware_py.transports.udp import UdpStations, UdpTransport
from sim_bridge.links.wire import BridgeCodec

SAMPLE, TICK = 50003, 50001
SECOND = 1_000_000


class Network:
    """A board, the station that it is configured for, and others; time passes when the board is told so."""

    def __init__(self, stations: int):
        self.clock = SimulatedClock((1 << 30) - 7 * SECOND)  # it wraps meanwhile
        self.configured = self._socket()
        self.others = [self._socket() for _ in range(stations)]
        self.board = UdpStations("127.0.0.1", self.configured.getsockname()[1], self.clock.ticks_us)
        self.board.write(b"first")
        data, self.address = self.configured.recvfrom(100)
        assert data == b"first"

    def _socket(self) -> socket.socket:
        one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        one.bind(("127.0.0.1", 0))
        one.settimeout(5.0)
        return one

    def say(self, station: socket.socket, data: bytes = b"hello") -> None:
        """`station` sends, and the board hears it."""
        station.sendto(data, self.address)
        assert self.board.wait(5000)
        assert self.board.read() == data

    def pass_time(self, seconds: float, *talking: socket.socket) -> None:
        """The board's loop goes on; `talking` stations beat their hearts."""
        for _ in range(round(seconds)):
            for station in talking:
                self.say(station)
            self.clock.now += SECOND
            self.board.write(b"state")

    def who_hears(self) -> list[int]:
        """The others that hear what the board sends now, by number."""
        for station in self.others:
            drained(station)
        drained(self.configured)
        self.board.write(b"to all")
        assert self.configured.recv(100) == b"to all"
        return [number for number, station in enumerate(self.others) if drained(station) == [b"to all"]]


def drained(station: socket.socket) -> list[bytes]:
    """What waits at a station."""
    found = []
    station.setblocking(False)
    with contextlib.suppress(BlockingIOError):
        while True:
            found.append(station.recv(100))
    station.settimeout(5.0)
    return found


@pytest.fixture
def network() -> Iterator[Network]:
    network = Network(9)
    yield network
    for one in (network.configured, *network.others):
        one.close()


def test_a_station_that_goes_on_sending_is_not_put_out_by_six_outsiders(network):
    second, *outsiders = network.others[:7]
    network.say(second)
    heard = 0
    for _ in range(250):
        for outsider in outsiders:
            network.say(outsider)
        network.clock.now += 20_000
        if network.clock.now % SECOND == 0:
            network.say(second)
        network.board.write(b"state")
        assert second.recv(100) == b"state"
        heard += 1
    assert heard == 250
    assert network.who_hears() == [0, 1, 2]


def test_one_that_fell_silent_gives_way_and_only_then(network):
    for station in network.others[:3]:
        network.say(station)
    network.pass_time(4, network.others[1], network.others[2])
    network.say(network.others[3])
    assert network.who_hears() == [0, 1, 2]  # four seconds are no silence
    network.pass_time(3, network.others[1], network.others[2])
    assert network.who_hears() == [0, 1, 2]  # and nobody else asks for its place
    network.say(network.others[3])
    assert network.who_hears() == [1, 2, 3]
    network.say(network.others[0])
    assert network.who_hears() == [1, 2, 3]


def test_a_silence_of_half_a_turn_of_the_clock_is_still_one(network):
    for station in network.others[:3]:
        network.say(station)
    network.pass_time(540)
    for station in network.others[3:6]:
        network.say(station)
    assert network.who_hears() == [3, 4, 5]


def received(link: MavlinkLink, transport: UdpStations | UdpTransport, inbox: Inbox) -> None:
    assert transport.wait(5000)
    link.receive(inbox)


def test_samples_come_from_the_configured_peer_alone_and_ticks_from_nobody(network):
    link, inbox = MavlinkLink(network.board), Inbox()
    codec = BridgeCodec()
    stranger = network.others[0]
    stranger.sendto(codec.encode(SAMPLE, sample(5 * SECOND, elevation=1.2)), network.address)  # of the future, too
    received(link, network.board, inbox)
    assert inbox.sample is None
    network.configured.sendto(codec.encode(SAMPLE, sample(SECOND)), network.address)
    received(link, network.board, inbox)
    taken = inbox.take_sample()
    assert taken is not None and taken[0] == SECOND
    for station in (stranger, network.configured):
        station.sendto(codec.encode(TICK, (1, 2)), network.address)
        received(link, network.board, inbox)
        assert inbox.tick is None
    assert link.refused == 3
    assert link.counters()[1] == 3


def test_on_the_pc_a_stranger_does_not_get_in_at_all():
    bridge, stranger = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
    with bridge, stranger:
        bridge.bind(("127.0.0.1", 0))
        transport = UdpTransport("127.0.0.1", bridge.getsockname()[1])
        transport.write(b"hello")
        _, address = bridge.recvfrom(100)
        stranger.sendto(b"believe me", ("127.0.0.1", address[1]))
        bridge.sendto(b"sample", address)
        assert transport.wait(5000)
        assert transport.read() == b"sample"
        assert transport.read() is None
