"""Ground stations come and go: real sockets, a flight in simulated time."""

import socket
from collections.abc import Iterator
from typing import Any

import pytest

from protocol import dialect
from sim_bridge.errors import ScenarioError
from sim_bridge.flight.flight import Flight
from sim_bridge.flight.truth_columns import COLUMNS
from sim_bridge.links.ground_path import GroundLink, GroundSettings, GroundSocket
from sim_bridge.links.link_settings import PathSettings
from sim_bridge.runtimes.memory import MemoryRuntime
from sim_bridge.scenario.scenario import load_scenario

_PATIENCE_TICKS = 20
_PARAMETERS = (b"INNER_P", b"OUTER_L", b"STEER_MAX")


class Simulator:
    """A kite in flight, with the bridge's own socket for ground stations."""

    def __init__(self) -> None:
        self._configured = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._configured.bind(("127.0.0.1", 0))
        scenario = load_scenario("paper-delay-tuned")
        scenario.set("ground.listen", "127.0.0.1:0", "test")
        scenario.set("ground.send_to", f"localhost:{self._configured.getsockname()[1]}", "test")
        self._socket = GroundSocket(scenario.ground)
        self.address = self._socket.address
        self.flight = Flight(scenario, MemoryRuntime(), GroundLink(PathSettings(), 1), self._socket)
        self.flight.fly(0.1)

    def heard_where_it_sends_to(self) -> list[bytes]:
        """The datagrams that lie where the kite sends to unasked."""
        return drained(self._configured)

    def mode(self) -> float:
        """The mode that it is in."""
        return self.flight.rows[-1][COLUMNS.index("mode")]

    def answer_there(self) -> None:
        """The station that the kite sends to speaks."""
        self._configured.sendto(b"\xfd whatever", self.address)

    def close(self) -> None:
        self._socket.close()
        self._configured.close()


@pytest.fixture
def simulator() -> Iterator[Simulator]:
    simulator = Simulator()
    yield simulator
    simulator.close()


class Station:
    """A ground station on a port of its own."""

    def __init__(self, simulator: Simulator, system: int = 255):
        self._simulator = simulator
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect(simulator.address)
        self._mav = dialect.MAVLink(None, srcSystem=system, srcComponent=190)
        self._parser = dialect.MAVLink(None)

    def say(self, message: Any) -> None:
        self._mav.seq = (self._mav.seq + 1) % 256
        self._socket.send(message.pack(self._mav))

    def ask(self, name: bytes) -> None:
        self.say(dialect.MAVLink_param_request_read_message(1, 1, name, -1))

    def greet(self) -> None:
        self.say(dialect.MAVLink_heartbeat_message(dialect.MAV_TYPE_GCS, 8, 0, 0, 4, 3))

    def heard(self) -> list[Any]:
        """Messages that have come since the last call."""
        return [message for data in drained(self._socket) for message in self._parser.parse_buffer(data) or []]

    def is_answered(self, kind: str) -> bool:
        """Whether an answer of this kind comes, while the flight goes on."""
        for _ in range(_PATIENCE_TICKS):
            self._simulator.flight.step()
            if any(message.get_type() == kind for message in self.heard()):
                return True
        return False

    def close(self) -> None:
        self._socket.close()


def drained(one: socket.socket) -> list[bytes]:
    one.setblocking(False)
    found = []
    while True:
        try:
            found.append(one.recv(65536))
        except OSError:
            return found


def test_five_hundred_that_come_one_after_the_other_are_all_answered(simulator):
    for number in range(500):
        station = Station(simulator)
        station.greet()
        station.ask(_PARAMETERS[number % 3])
        assert station.is_answered("PARAM_VALUE"), f"number {number} was not answered"
        station.close()
    last = Station(simulator)
    last.say(dialect.MAVLink_command_long_message(
        1, 1, dialect.MAV_CMD_COMPONENT_ARM_DISARM, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert last.is_answered("COMMAND_ACK")
    simulator.flight.fly(simulator.flight.time_s + 0.1)
    assert simulator.mode() == dialect.KITE_MODE_STANDBY
    last.close()


def test_twenty_at_once_are_all_answered(simulator):
    stations = [Station(simulator) for _ in range(20)]
    for station in stations:
        station.greet()
        station.ask(b"OUTER_L")
    simulator.flight.fly(simulator.flight.time_s + 0.5)
    for station in stations:
        assert "PARAM_VALUE" in {message.get_type() for message in station.heard()}
        station.close()


def test_of_more_than_thirty_two_the_longest_silent_one_gives_way(simulator):
    stations = [Station(simulator) for _ in range(33)]
    for station in stations[:32]:
        station.greet()
        simulator.flight.step()
    stations[0].greet()  # so that the second is the longest silent
    simulator.flight.step()
    assert all(station.heard() for station in stations[:32])
    stations[32].greet()
    simulator.flight.step()
    assert stations[32].heard()
    for station in stations:
        station.heard()
    simulator.heard_where_it_sends_to()
    simulator.flight.fly(simulator.flight.time_s + 0.2)
    assert [bool(station.heard()) for station in stations] == [True, False] + [True] * 31
    assert simulator.heard_where_it_sends_to()
    for station in stations:
        station.close()


def test_neither_the_one_that_it_sends_to_nor_noise_takes_a_place(simulator):
    simulator.answer_there()
    station = Station(simulator)
    station._socket.send(b"who is there?")
    simulator.flight.fly(simulator.flight.time_s + 0.2)
    there = simulator.heard_where_it_sends_to()
    assert len(there) == len(set(there)) > 10  # each frame comes once
    assert not station.heard()
    station.close()


def test_two_stations_at_once_both_rule_and_both_know(simulator):
    """One asks for PARK, the other for TRACK and another gain: both hear all of it, the last word holds."""
    first, second = Station(simulator), Station(simulator, system=254)
    for station in (first, second):
        station.greet()
    simulator.flight.step()
    mode = dialect.MAV_CMD_DO_SET_MODE
    for station, number in ((first, dialect.KITE_MODE_PARK), (second, dialect.KITE_MODE_TRACK)):
        station.say(dialect.MAVLink_command_long_message(
            1, 1, mode, 0, 1.0, float(number), 0.0, 0.0, 0.0, 0.0, 0.0))
        simulator.flight.fly(simulator.flight.time_s + 0.4)
        assert simulator.mode() == number
    second.say(dialect.MAVLink_param_set_message(1, 1, b"INNER_P", 2.0, dialect.MAV_PARAM_TYPE_REAL32))
    simulator.flight.fly(simulator.flight.time_s + 0.2)
    for station in (first, second):
        heard = station.heard()
        modes = [message.custom_mode for message in heard if message.get_type() == "HEARTBEAT"]
        assert dialect.KITE_MODE_PARK in modes and modes[-1] == dialect.KITE_MODE_TRACK
        values = [message.param_value for message in heard if message.get_type() == "PARAM_VALUE"]
        assert values[-1] == 2.0
        station.close()


def test_an_address_that_nobody_knows_is_one_line():
    with pytest.raises(ScenarioError, match=r"^ground\.send_to = no such host:14550: unknown host no such host"):
        GroundSocket(GroundSettings(send_to="no such host:14550"))
