"""A recorded flight as CSV and as ULog: every value as it was sent, read back by others' readers."""

import csv
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from ground.cli.main import main
from ground.logs.reader import MessageLog, read_message_log
from kite_analysis.flights.tlog import TlogWriter
from protocol import dialect
from protocol.clock import counted_on
from sim_bridge.links.link_settings import LinkSettings
from tests.ground.recorded_flights import record

WRAP_US = 1 << 30


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("flights")


@pytest.fixture
def flight(flying_kite, folder) -> MessageLog:
    path = folder / "flight.tlog"
    return read_message_log(path) if path.exists() else record(flying_kite("paper-delay-tuned"), path)


def states(log: MessageLog) -> list[dialect.MAVLink_kite_state_message]:
    return [entry.message for entry in log.messages if isinstance(entry.message, dialect.MAVLink_kite_state_message)]


def read_csv(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_the_flight_as_a_table(flight, tmp_path, capsys):
    out = tmp_path / "flight.csv"
    assert main(["log", "export", str(flight.path), "--out", str(out)]) == 0
    rows, sent = read_csv(out), states(flight)
    assert capsys.readouterr().out == f"{len(sent)} rows written to {out}\n"
    assert len(rows) == len(sent) > 600
    for row, state in zip(rows, sent, strict=True):
        for column, field in (("azimuth_rad", "azimuth"), ("course_rad", "course"), ("cross_track_rad", "cross_track"),
                              ("steering_asked", "steering_asked"), ("airspeed_m_s", "airspeed")):
            assert np.float32(row[column]) == np.float32(getattr(state, field))
        error = float(row["target_course_rad"]) - float(row["course_rad"])
        assert math.cos(error) == pytest.approx(math.cos(float(row["course_error_rad"])))
        assert row["tether_force_n"] == "" or state.valid & dialect.KITE_VALID_TETHER_FORCE
    assert np.diff([float(row["vehicle_time_s"]) for row in rows]) == pytest.approx(0.02, abs=2e-6)
    modes = [row["mode"] for row in rows]
    changes = [mode for before, mode in pairwise(modes) if mode != before]
    assert changes[-2:] == ["PARK", "TRACK"]
    assert main(["log", "export", str(flight.path), "--out", str(out)]) == 2
    assert "already exists" in capsys.readouterr().err


def test_messages_that_overtook_each_other_are_put_in_order(simulated_kite, operator_of, tmp_path):
    """60 ms of jitter either way on a link of 0.1 s: rows stand in the order of the vehicle's clock, 20 ms apart."""
    operator = operator_of(simulated_kite(links=[LinkSettings(delay_s=0.1, jitter_s=0.06)]))
    operator.runs("record", tmp_path / "flight.tlog", "--duration", "10")
    assert operator.runs("log", "export", tmp_path / "flight.tlog") == 0
    rows = read_csv(tmp_path / "flight.csv")[10:-10]  # at the ends, some were on their way
    vehicle_s, time_s, received_s = (np.array([float(row[name]) for row in rows])
                                     for name in ("vehicle_time_s", "time_s", "received_s"))
    assert np.diff(received_s).min() < 0.0
    assert np.diff(vehicle_s) == pytest.approx(0.02, abs=2e-6) and np.diff(time_s) == pytest.approx(0.02, abs=2e-6)
    delay_s = received_s - time_s
    assert 0.0 <= delay_s.min() < 1e-3 and 0.1 < delay_s.max() <= 0.14


def test_a_clock_that_wraps_and_a_board_that_starts_anew():
    received_s = np.arange(0.0, 3000.0, 0.5)
    wrapping_us = (received_s * 1e6 + 5e8) % WRAP_US
    assert counted_on(wrapping_us, received_s) == pytest.approx(received_s)
    anew_us = np.where(received_s < 700.0, wrapping_us, (received_s - 700.0) * 1e6 % WRAP_US)
    assert counted_on(anew_us, received_s) == pytest.approx(received_s)
    silent = (received_s < 100.0) | (received_s > 1500.0)
    assert counted_on(wrapping_us[silent], received_s[silent]) == pytest.approx(received_s[silent])


def test_every_message_in_a_file_of_its_kind(flight, tmp_path):
    out = tmp_path / "messages"
    assert main(["log", "export", str(flight.path), "--all", "--out", str(out)]) == 0
    names = {entry.message.get_type().lower() for entry in flight.messages}
    assert {path.stem for path in out.iterdir()} == names
    values = [entry.message for entry in flight.messages if entry.message.get_type() == "PARAM_VALUE"]
    rows = read_csv(out / "param_value.csv")
    assert [(row["param_id"], np.float32(row["param_value"])) for row in rows] == [
        (message.param_id, np.float32(message.param_value)) for message in values]
    assert len(read_csv(out / "kite_state.csv")) == len(states(flight))


def test_ulog_opens_with_pyulog_and_holds_everything(flight, tmp_path):
    pyulog = pytest.importorskip("pyulog")
    out = tmp_path / "flight.ulg"
    assert main(["log", "export", str(flight.path), "--format", "ulog", "--out", str(out)]) == 0
    ulog = pyulog.ULog(str(out))
    assert not ulog.file_corruption and ulog.dropouts == []
    kite, sent = ulog.get_dataset("kite_state").data, states(flight)
    for field in dialect.MAVLink_kite_state_message.fieldnames:
        assert kite[field].tolist() == [getattr(state, field) for state in sent], field
    times_us = [round(entry.time_s * 1e6) for entry in flight.messages if entry.message.get_type() == "KITE_STATE"]
    assert kite["timestamp"].tolist() == times_us
    told = [entry.message for entry in flight.messages if entry.message.get_type() == "PARAM_VALUE"]
    gains = [message.param_value for message in told if message.param_id == "INNER_P"]
    assert ulog.initial_parameters["INNER_P"] == gains[0] != 2.5
    assert len(ulog.initial_parameters) == told[0].param_count
    assert [(name, value) for _, name, value in ulog.changed_parameters] == [("INNER_P", 2.5)]
    assert {message.message for message in ulog.logged_messages} >= {"mode PARK", "mode TRACK"}
    assert ulog.msg_info_dict["log_start_utc_us"] == flight.start_us
    names = {(entry.message.get_type().lower(), entry.sender) for entry in flight.messages}
    assert len(ulog.data_list) == len(names)


@pytest.mark.parametrize("wild_us", [0, 2**63, 2**64 - 1])
def test_wild_stamps_cost_nothing_but_their_time(flight, tmp_path, capsys, wild_us):
    """The first, the last and one frame in a hundred have a stamp of no date: every message is exported and drawn, in
    the flight's time, with a line that says so."""
    pyulog = pytest.importorskip("pyulog")
    wild = tmp_path / "wild.tlog"
    with TlogWriter(wild) as writer:
        for index, entry in enumerate(flight.messages):
            at_us = flight.start_us + round(entry.time_s * 1e6)
            last = index == len(flight.messages) - 1
            writer.write(wild_us if index % 100 == 0 or last else at_us, entry.frame)
    assert main(["log", "export", str(wild), "--format", "ulog"]) == 0
    (said,) = capsys.readouterr().err.splitlines()
    assert "the recorder's clock jumps" in said and said.endswith("jumps removed, all messages used")
    ulog = pyulog.ULog(str(wild.with_suffix(".ulg")))
    assert not ulog.file_corruption
    assert ulog.msg_info_dict["log_start_utc_us"] == pytest.approx(flight.start_us, abs=1e6)
    assert len(ulog.get_dataset("kite_state").data["timestamp"]) == len(states(flight))
    again = read_message_log(wild)
    assert len(again.messages) == len(flight.messages)
    assert again.duration_s == pytest.approx(flight.duration_s, rel=0.05)
    assert main(["log", "export", str(wild)]) == 0
    assert main(["plot", str(wild)]) == 0
    assert main(["log", "export", str(wild), "--all"]) == 0


def test_a_log_of_nothing_but_wild_stamps_counts_from_its_start(flight, tmp_path, capsys):
    wild = tmp_path / "wild.tlog"
    with TlogWriter(wild) as writer:
        for index, entry in enumerate(flight.messages):
            writer.write(2**64 - 1 - 1000 * index if index % 2 else 2**63 + 1000 * index, entry.frame)
    assert main(["log", "export", str(wild), "--format", "ulog"]) == main(["log", "export", str(wild)]) == 0
    assert main(["plot", str(wild)]) == 2
    assert "lasts 0.0 s: nothing of it is from 0 to 0 s" in capsys.readouterr().err
    assert read_message_log(wild).start_us == 0


def test_what_cannot_be_exported_is_answered_in_one_line(flight, tmp_path, capsys):
    for arguments, said in ((["--out", str(flight.path / "f.csv")], "is not a folder"),
                            (["--format", "ulog", "--all"], "--all goes with --format csv"),
                            (["--system", "9"], "holds the autopilots of systems 1: check --system")):
        assert main(["log", "export", str(flight.path), *arguments]) == 2
        error = capsys.readouterr().err
        assert said in error and error.count("\n") == 1
    full = Path("/dev/full")
    if full.exists():
        (tmp_path / "f.csv").symlink_to(full)
        assert main(["log", "export", str(flight.path), "--force", "--out", str(tmp_path / "f.csv")]) == 2
        assert "cannot write: No space left" in capsys.readouterr().err
