"""Wi-Fi that comes and goes: nothing waits for it, and it is joined again."""

from simulated_hardware import SimulatedClock

from firmware_py.transports.wifi import WifiTransport


class Network:
    """A network interface and the UDP behind it."""

    def __init__(self):
        self.joins = []
        self.there = False
        self.busy = False
        self.sent = []
        self.incoming = []
        self.said = []
        self.clock = SimulatedClock((1 << 30) - 3_000_000)
        self.from_peer = True

    def connect(self, *credentials):
        self.joins.append(credentials)
        if self.busy:
            raise OSError("busy")

    def isconnected(self):
        return self.there

    def status(self):
        return -3

    def ifconfig(self):
        return ("192.168.1.7", "", "", "")

    def read(self):
        return self.incoming.pop(0) if self.incoming else None

    def write(self, data):
        self.sent.append(data)

    def wait(self, timeout_ms):
        return False

    def transport(self, key="12345678"):
        return WifiTransport(self, "kite", key, self, self.clock.ticks_us, self.said.append)

    def run(self, transport, seconds):
        for _ in range(seconds * 50):
            self.clock.now += 20_000
            transport.write(b"frame")


def test_it_joins_and_sends_once_it_has():
    network = Network()
    transport = network.transport()
    assert network.joins == [("kite", "12345678")] and transport.datagrams
    network.run(transport, 2)
    assert network.sent == [] and network.said == []
    network.there = True
    network.run(transport, 1)
    assert network.said == ["Wi-Fi kite: connected as 192.168.1.7"]
    assert 35 < len(network.sent) <= 50


def test_an_open_network_is_joined_without_a_key():
    network = Network()
    network.transport("")
    assert network.joins == [("kite",)]


def test_it_tries_again_each_ten_seconds_and_says_so_even_if_the_radio_is_busy():
    network = Network()
    transport = network.transport()
    network.busy = True
    network.run(transport, 31)
    assert len(network.joins) == 4
    assert network.said[:2] == ["Wi-Fi kite: not connected (status -3), retrying", "Wi-Fi kite: busy"]


def test_a_network_that_drops_costs_nothing_but_what_was_sent_and_is_joined_again():
    network = Network()
    transport = network.transport()
    network.there = True
    network.run(transport, 1)
    network.there = False
    network.run(transport, 11)
    assert network.said[1] == "Wi-Fi kite: lost" and len(network.joins) == 2
    network.there = True
    sent = len(network.sent)
    network.run(transport, 1)
    assert len(network.sent) > sent + 35


def test_what_arrives_is_counted():
    network = Network()
    transport = network.transport()
    network.incoming = [b"12345", b"678"]
    assert [transport.read(), transport.read(), transport.read()] == [b"12345", b"678", None]
    assert transport.received == 8 and not transport.wait(5)
