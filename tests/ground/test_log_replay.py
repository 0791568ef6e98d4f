"""A recorded flight, fed back: a second ground station sees the same flight, and is told what a replay cannot do."""

import os
import socket
import struct
import subprocess
import sys
from collections import deque
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common

from ground.cli.main import main
from ground.errors import NoAnswerError, VehicleError
from ground.link.links import Links
from ground.link.statistics import LinkStatistics
from ground.link.transports import OnePeer
from ground.logs.parameters import LoggedParameters
from ground.logs.reader import MessageLog, read_message_log
from ground.logs.recorder import Recorder
from ground.replay.numbering import renumbered
from ground.replay.player import Replay
from ground.session import Session
from kite_analysis.flights.tlog import TlogWriter
from protocol import dialect
from tests.ground.recorded_flights import let_pass, payloads, record

_STEP_S = 0.005
_SEEN = (dialect.MAVLink_kite_state_message, dialect.MAVLink_heartbeat_message, dialect.MAVLink_statustext_message,
         dialect.MAVLink_sys_status_message, dialect.MAVLink_local_position_ned_message)


class Replayed:
    """A replay and the ground station that watches it, on one simulated clock; time passes while the latter waits."""

    def __init__(self, log: MessageLog, **settings) -> None:
        self._now_s = 0.0
        self._down: deque[bytes] = deque()
        self._up: deque[bytes] = deque()
        self.replay = Replay(log, Wire(self._down, lambda: self._up.popleft() if self._up else b""),
                             self.clock, **settings)
        links = Links({"replay": lambda: Wire(self._up, self._wait)}, self.clock, print)
        links.open()
        self.session = Session(links, print)

    def clock(self) -> float:
        return self._now_s

    def to_the_end(self) -> None:
        assert self.session.connection.wait_until(lambda: self.replay.over, 100.0)

    def _wait(self) -> bytes:
        if not self._down:
            self._now_s += _STEP_S
            self.replay.poll(0.0)
        return self._down.popleft() if self._down else b""


class Wire(OnePeer):
    """One end of a wire: what is sent goes into a queue, and receiving is what the other end makes of it."""

    def __init__(self, queue: deque[bytes], receive) -> None:
        self._queue, self._receive = queue, receive

    def send(self, data: bytes) -> None:
        self._queue.append(data)

    def receive(self, timeout_s: float) -> bytes:
        return self._receive()

    def fileno(self) -> None:
        return None

    def close(self) -> None:
        pass


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("flights")


@pytest.fixture
def flight(flying_kite, folder) -> MessageLog:
    """14 s of flight over a link that loses 5 % each way."""
    path = folder / "flight.tlog"
    return read_message_log(path) if path.exists() else record(flying_kite("paper-delay-tuned", loss=0.05), path)


def test_a_replay_recorded_again_is_the_same_flight(flight, tmp_path):
    again = Replayed(flight)
    path = tmp_path / "again.tlog"
    with Recorder(again.session.connection, path, 1.7e9):
        again.to_the_end()
    second = read_message_log(path)
    for kind in _SEEN:
        assert payloads(second, kind) == payloads(flight, kind), kind.msgname
    assert len(payloads(second, dialect.MAVLink_kite_state_message)) > 500
    first_values, second_values = (LoggedParameters(log, log.vehicle()) for log in (flight, second))
    assert second_values.complete and second_values.values(14.0) == first_values.values(14.0)
    assert [change[1:] for change in second_values.changes()] == [change[1:] for change in first_values.changes()]
    assert first_values.changes()[0].name == "INNER_P"
    for one, other in zip(first_values.changes(), second_values.changes(), strict=True):
        assert other.time_s == pytest.approx(one.time_s, abs=2 * _STEP_S)


def test_a_ground_station_that_connects_gets_the_parameters_of_that_moment(flight):
    """The link is as bad as it was recorded, and no worse for the answers that were put in between."""
    again = Replayed(flight)
    session = again.session
    session.find_vehicle(5.0)
    assert session.contract.wait(5.0)
    early = session.parameters.fetch_all()
    again.to_the_end()
    assert early == LoggedParameters(flight, flight.vehicle()).values(1.0)
    assert early["INNER_P"] != 2.5
    entries = list(flight.of(flight.vehicle()))
    recorded = LinkStatistics()
    for entry in entries[next(at for at, entry in enumerate(entries) if entry.message.get_type() == "HEARTBEAT"):]:
        recorded.add(entry.time_s, entry.header.sequence, entry.sender.component)
    assert session.connection.statistics.lost == recorded.lost > 20
    assert again.replay.answered > 10
    assert session.state.mode == dialect.KITE_MODE_TRACK


def test_a_replay_takes_no_value_and_no_command_and_says_so_at_once(flight):
    again = Replayed(flight)
    session = again.session
    session.find_vehicle(5.0)
    start_s = again.clock()
    with pytest.raises(VehicleError, match="read-only"):
        session.parameters.set("OUTER_L", 7.0)
    with pytest.raises(VehicleError, match="a flight of the past takes no command"):
        session.commander.set_mode(dialect.KITE_MODE_MANUAL)
    with pytest.raises(VehicleError, match="a flight of the past takes no command"):
        session.commander.disarm()
    assert session.parameters.fetch("OUTER_L") != 7.0
    assert again.clock() - start_s < 4.0


def test_a_log_with_some_of_the_parameters_or_none_leaves_nobody_waiting(flight, tmp_path):
    for kept in (["INNER_P", "OUTER_L"], []):
        path = tmp_path / f"{len(kept)}.tlog"
        with TlogWriter(path) as writer:
            for entry in flight.messages:
                if getattr(entry.message, "param_id", None) in (None, *kept):
                    writer.write(flight.start_us + round(entry.time_s * 1e6), entry.frame)
        session = Replayed(read_message_log(path), loop=True).session
        session.find_vehicle(5.0)
        with pytest.raises(VehicleError):
            session.parameters.fetch("EIGHT_HALF_W")
        if kept:
            assert list(session.parameters.fetch_all()) == kept
        else:
            with pytest.raises(NoAnswerError):
                session.parameters.fetch_all()
            assert "replay: this log holds no parameters" in [text.text for text in session.state.texts]


def test_files_and_missions_are_refused_at_once(flight):
    """As MAVProxy and QGroundControl ask for them, in messages that the kite's own dialect need not have."""
    down, up = deque(), deque()
    replay = Replay(flight, Wire(down, lambda: up.popleft() if up else b""), lambda: 0.0)
    station = common.MAVLink(None, 255, 190)
    path = b"@PARAM/param.pck"
    opening = struct.pack("<HBBBBBxI", 7, 0, 4, len(path), 0, 0, 0) + path
    up.append(common.MAVLink_file_transfer_protocol_message(0, 1, 1, opening.ljust(251, b"\0")).pack(station))
    up.append(common.MAVLink_mission_request_list_message(1, 1, 0).pack(station))
    up.append(common.MAVLink_mission_request_list_message(9, 1, 0).pack(station))
    while up:
        replay.poll(0.0)
    answers = [common.MAVLink(None).decode(bytearray(frame)).to_dict() for frame in list(down)[-2:]]
    names = [answer["mavpackettype"] for answer in answers]
    assert names == ["FILE_TRANSFER_PROTOCOL", "MISSION_COUNT"] and answers[1]["count"] == 0
    assert {(answer["target_system"], answer["target_component"]) for answer in answers} == {(255, 190)}
    nak = (8, 0, 129, 1, 4, 0, 0, 10)  # no such file
    assert struct.unpack_from("<HBBBBBxIB", list(down)[-2][13:]) == nak


def test_pause_speed_loop_and_a_part_of_it(flight):
    again = Replayed(flight, speed=4.0, from_s=2.0, to_s=6.0, loop=True)
    session, replay = again.session, again.replay
    let_pass(session, 0.5)
    assert replay.position_s == pytest.approx(4.0, abs=0.1)
    assert session.state.kite is not None
    replay.paused = True
    let_pass(session, _STEP_S)
    sent, beats = replay.sent, []
    session.connection.add_observer(lambda time_s, message, frame: beats.append((time_s, message.get_type())))
    let_pass(session, 10.0)
    assert replay.sent == sent and replay.position_s == pytest.approx(4.0, abs=0.1)
    heart = [time_s for time_s, name in beats if name == "HEARTBEAT"]
    assert max(later - earlier for earlier, later in pairwise(heart)) < 3.0
    replay.paused, replay.speed = False, 2.0
    let_pass(session, 1.1)
    assert replay.laps == 1
    let_pass(session, 6.0)
    assert replay.laps == 4 and not replay.over


def test_a_loop_loses_nothing_where_it_starts_over(flying_kite, tmp_path):
    again = Replayed(record(flying_kite("paper-no-delay"), tmp_path / "flight.tlog"), loop=True, speed=8.0)
    let_pass(again.session, 9.0)
    assert again.replay.laps >= 4
    statistics = again.session.connection.statistics
    assert statistics.received > 1000 and (statistics.lost, statistics.repeated) == (0, 0)


@given(payload=st.binary(max_size=255), extra=st.integers(0, 255), number=st.integers(0, 255),
       other=st.integers(0, 255), version=st.sampled_from([1, 2]))
def test_a_frame_of_any_kind_can_be_numbered_anew(payload, extra, number, other, version):
    """The checksum is what the sender, who knows the CRC extra, would have computed."""
    def frame(sequence: int) -> bytes:
        head = bytes([len(payload), sequence, 1, 1, 99]) if version == 1 else bytes(
            [len(payload), 0, 0, sequence, 1, 1, 99, 88, 0])
        checksum = dialect.x25crc(head + payload + bytes([extra])).crc
        return bytes([0xFE if version == 1 else 0xFD]) + head + payload + checksum.to_bytes(2, "little")

    assert renumbered(frame(number), other) == frame(other)


def test_the_command_feeds_a_port_and_says_when_nobody_is_there(flight, capsys):
    wanted = [entry for entry in flight.messages if 5.0 <= entry.time_s <= 5.5]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as station:
        station.bind(("127.0.0.1", 0))
        port = station.getsockname()[1]
        assert main(["replay", str(flight.path), "--to", f"udpout:127.0.0.1:{port}", "--speed", "50",
                     "--from", "5", "--to-time", "5.5"]) == 0
        station.settimeout(30.0)
        assert station.recv(500)[10:-2] == wanted[0].frame[10:-2]
    output = capsys.readouterr()
    assert "messages replayed in" in output.out
    assert f"no ground station answered: is one listening on 127.0.0.1:{port}?" in output.err
    assert main(["replay", str(flight.path), "--from", "500"]) == 2
    assert "lasts 1" in capsys.readouterr().err


def test_keys_pause_it_and_end_it_in_a_terminal(flight):
    """Space, then q; the terminal is left as it was."""
    termios = pytest.importorskip("termios")
    ours, theirs = os.openpty()
    before = termios.tcgetattr(theirs)
    command = [sys.executable, "-c", "import sys; from ground.cli.main import main; sys.exit(main())", "replay",
               str(flight.path), "--to", "udpout:127.0.0.1:9", "--loop"]
    with subprocess.Popen(command, stdin=theirs, stderr=theirs, stdout=subprocess.PIPE) as process:
        shown = read_until(ours, b"speed 1")
        os.write(ours, b"+")
        read_until(ours, b"speed 2")
        os.write(ours, b" ")
        shown = read_until(ours, b"paused")
        os.write(ours, b"q")
        assert process.wait() == 0
    assert b"of 0:1" in shown and b"q quits" in shown
    assert termios.tcgetattr(theirs) == before
    os.close(ours)
    os.close(theirs)


def read_until(file: int, wanted: bytes) -> bytes:
    """What comes until `wanted` has."""
    came = b""
    while wanted not in came:
        came += os.read(file, 1000)
    return came
