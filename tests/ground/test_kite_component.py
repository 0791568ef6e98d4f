"""KITE_STATE has a component of its own: who does not know it misses nothing, and old logs are still read."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ground.logs.quantities import link_quality, recorded_flight
from ground.logs.reader import read_message_log
from ground.replay.numbering import renumbered
from ground.replay.player import Replay
from kite_analysis.flights.record import COLUMNS, FlightRecord
from kite_analysis.flights.telemetry import read_tlog_record
from kite_analysis.flights.tlog import TlogWriter, read_tlog
from protocol import dialect
from sim_bridge.flight.flight import Flight
from sim_bridge.flight.tick_record import TickRecord
from sim_bridge.runtimes.memory import MemoryRuntime
from sim_bridge.scenario.scenario import load_scenario

OLD, NEW = dialect.MAV_COMP_ID_AUTOPILOT1, dialect.MAV_COMP_ID_USER1
STATE = dialect.MAVLINK_MSG_ID_KITE_STATE


# What pymavlink's mavutil counts, on which MAVProxy's "loss" rests: a process, as it keeps its dialect in a global.
MAVUTIL = """
import sys
from pymavlink import mavutil
log = mavutil.mavlink_connection(sys.argv[1], dialect="common")
log.recv_msg()
before = log.mav_loss  # opening the file reads its first frames, and then once more
while log.recv_msg():
    pass
print(log.mav_count, log.mav_loss - before, sorted(set(log.last_seq)))
"""


def as_mavutil_counts(path: Path) -> tuple[int, int, list[tuple[int, int]]]:
    """Messages that a station with common.xml knows, how many it misses, and of whom, by (system, component)."""
    done = subprocess.run([sys.executable, "-c", MAVUTIL, str(path)], env=os.environ | {"MAVLINK20": "1"}, text=True,
                          capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    count, loss, senders = done.stdout.split(" ", 2)
    return int(count), int(loss), ast.literal_eval(senders)


@pytest.fixture(scope="module")
def logged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A few seconds of a flight, as it was said."""
    path = tmp_path_factory.mktemp("flown") / "ground.tlog"
    with TlogWriter(path) as log:
        def watch(tick: TickRecord) -> None:
            for frame in tick.output.frames:
                log.write(round((100.0 + tick.time_s) * 1e6), frame)

        Flight(load_scenario("paper-delay-tuned"), MemoryRuntime(), watch=watch).fly(6.0)
    return path


def frames_of(path: Path) -> list[bytes]:
    return [frame for _, frame in read_tlog(path)]


def as_before(path: Path, out: Path) -> None:
    """The log that an older firmware would have left: one component, one sequence."""
    with TlogWriter(out) as log:
        for number, (time_us, frame) in enumerate(read_tlog(path)):
            mine = bytearray(frame)
            mine[6] = OLD
            message = int.from_bytes(frame[7:10], "little")
            crc = dialect.x25crc(mine[1:-2])
            crc.accumulate(bytes([dialect.mavlink_map[message].crc_extra]))
            mine[-2:] = crc.crc.to_bytes(2, "little")
            log.write(time_us, renumbered(bytes(mine), number % 256))


def test_a_station_without_our_dialect_counts_no_loss(logged):
    count, loss, senders = as_mavutil_counts(logged)
    assert count > 30 and loss == 0
    assert senders == [(1, OLD)]
    states = [frame for frame in frames_of(logged) if int.from_bytes(frame[7:10], "little") == STATE]
    assert len(states) > 250 and {frame[6] for frame in states} == {NEW}
    assert [frame[4] for frame in states[1:]] == [(frame[4] + 1) % 256 for frame in states[:-1]]


def test_there_would_have_been_loss_before(logged, tmp_path):
    as_before(logged, tmp_path / "old.tlog")
    count, loss, _ = as_mavutil_counts(tmp_path / "old.tlog")
    assert loss > count


def test_a_log_of_either_kind_gives_the_same_flight(logged, tmp_path):
    as_before(logged, tmp_path / "old.tlog")
    flights: list[FlightRecord] = []
    for path in (logged, tmp_path / "old.tlog"):
        log = read_message_log(path)
        assert log.vehicle() == (1, OLD)
        flights.append(recorded_flight(log, log.vehicle()))
        _, loss, rate = link_quality(log, log.vehicle())
        assert max(loss) == 0.0 and rate[-1] > 40.0
    new, old = flights
    assert len(new.time_s) > 250
    for name in ("time_s", *COLUMNS):
        assert getattr(new, name) == pytest.approx(getattr(old, name), nan_ok=True), name
    for name, values in new.further.items():
        assert values == pytest.approx(old.further[name], nan_ok=True), name
    records = [read_tlog_record(path) for path in (logged, tmp_path / "old.tlog")]
    assert records[0].course == pytest.approx(records[1].course, nan_ok=True)


def test_a_log_without_a_heartbeat_is_of_the_autopilot_all_the_same(logged, tmp_path):
    with TlogWriter(tmp_path / "cut.tlog") as log:
        for time_us, frame in read_tlog(logged):
            if int.from_bytes(frame[7:10], "little") == STATE:
                log.write(time_us, frame)
    log = read_message_log(tmp_path / "cut.tlog")
    assert log.vehicle() == (1, OLD)
    assert len(recorded_flight(log, log.vehicle()).time_s) > 250


def test_a_replay_that_is_asked_for_the_state_numbers_it_with_its_own(logged):
    class Transport:
        def __init__(self) -> None:
            self.sent: list[bytes] = []
            self.coming = b""

        def send(self, data: bytes) -> None:
            self.sent.append(data)

        def receive(self, timeout_s: float) -> bytes:
            data, self.coming = self.coming, b""
            return data

    transport, now = Transport(), [0.0]
    replay = Replay(read_message_log(logged), transport, lambda: now[0])  # type: ignore[arg-type]
    ask = dialect.MAVLink_command_long_message(1, 1, 512, 0, float(STATE), 0, 0, 0, 0, 0, 0)
    while replay.poll(0.0):
        now[0] += 0.05
        transport.coming = ask.pack(dialect.MAVLink(None, 255, 190))
    assert replay.answered > 50
    for component in (OLD, NEW):
        numbers = [frame[4] for frame in transport.sent if frame[6] == component]
        assert numbers[1:] == [(number + 1) % 256 for number in numbers[:-1]], component
