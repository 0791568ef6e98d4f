"""What an operator does with kite-ground, from the arguments to the real firmware, on a good link in simulated time."""

import json
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

from ground.cli import monitor_view
from ground.errors import NoAnswerError, UsageError, VehicleError
from ground.logs.recorder import Recorder
from kite_analysis.delay.inner_loop import optimal_gain, stability_limit
from kite_analysis.flights.tlog import read_tlog
from protocol import dialect
from protocol.parameter_table import load_parameters
from protocol.single_precision import float32
from sim_bridge.links.link_settings import LinkSettings


def test_look_change_save_and_go_back(operator, tmp_path):
    """Look at a gain, save all, change two, see the difference, and load the file to be back where it began."""
    before = tmp_path / "before.param"
    assert operator.runs("param", "get", "outer_l", "--json") == 0
    assert json.loads(operator.said)["value"] == 5.0
    assert operator.runs("param", "save", before) == 0
    assert f"{len(load_parameters())} parameters written" in operator.said
    operator.is_told(UsageError, "already exists", "param", "save", before)
    assert operator.runs("param", "set", "OUTER_L", "6.1") == 0
    assert operator.said == "OUTER_L = 6.1, acknowledged by the kite\n"
    assert operator.runs("param", "set", "EIGHT_AZIMUTH", "-5") == 0
    assert operator.runs("param", "show", "--changed", "--json") == 0
    assert {name: facts["value"] for name, facts in json.loads(operator.said).items()} == {
        "OUTER_L": 6.1, "EIGHT_AZIMUTH": -5.0}
    assert operator.runs("param", "diff", before) == 0
    assert [line.split()[:3] for line in operator.said.splitlines()[1:]] == [
        ["OUTER_L", "6.1", "5"], ["EIGHT_AZIMUTH", "-5", "0"]]
    assert operator.kite.firmware_parameter("OUTER_L") == float32(6.1)
    assert operator.runs("param", "load", before, "--yes") == 0
    assert operator.said.count(", acknowledged by the kite\n") == 2
    assert operator.kite.firmware_parameter("OUTER_L") == 5.0
    assert operator.kite.firmware_parameter("EIGHT_AZIMUTH") == 0.0
    assert operator.runs("param", "load", before, "--yes") == 0
    assert operator.said.endswith("nothing to set\n")


def test_a_load_sends_nothing_unasked_and_nothing_unknown(operator, tmp_path, monkeypatch):
    path = tmp_path / "new.param"
    path.write_text("INNER_P,2.5\nOUTER_LL,6\n")
    operator.is_told(UsageError, r"new.param:2: the kite has no parameter OUTER_LL; did you mean OUTER_L\?",
                     "param", "load", path, "--yes")
    path.write_text("INNER_P,2.5\nTABLE_VERSION,9\n")
    with path.with_name("answer").open("w+") as answer:
        monkeypatch.setattr(sys, "stdin", answer)
        answer.write("n\n")
        answer.seek(0)
        assert operator.runs("param", "load", path) == 0
        assert "nothing was set" in operator.said and operator.kite.firmware_parameter("INNER_P") == 1.5
        answer.seek(0)
        answer.write("y\n")
        answer.seek(0)
        assert operator.runs("param", "load", path) == 0
    assert "TABLE_VERSION is read-only" in operator.remarked
    assert operator.kite.firmware_parameter("INNER_P") == 2.5
    assert operator.kite.firmware_parameter("TABLE_VERSION") == load_parameters()["TABLE_VERSION"].default


def test_what_was_never_loaded_is_never_saved(operator, tmp_path):
    """The link goes while the list comes: no file, and above all none with zeros in it."""
    connect, kite = operator.connect, operator.kite

    def connect_and_lose():
        session = connect()
        session.check_contract()
        seen = []
        session.connection.add_observer(lambda time_s, message, frame: (
            seen.append(message) if message.get_type() == "PARAM_VALUE" else None,
            kite.change_link(LinkSettings(loss=1.0), LinkSettings()) if len(seen) == 10 else None))
        return session

    operator.connect = connect_and_lose
    path = tmp_path / "half.param"
    operator.is_told(NoAnswerError, r"^[A-Z_]+ and \d+ more of \d+: no answer in \d+ s.*the link is down",
                     "param", "save", path)
    assert list(tmp_path.glob("half*")) == []


def test_watch_tells_what_another_ground_station_sets(operator):
    request = dialect.MAVLink_param_set_message(1, 1, b"OUTER_L", 6.5, dialect.MAV_PARAM_TYPE_REAL32)
    frame = request.pack(dialect.MAVLink(None, 254, 190))
    kite = operator.kite
    step, sent = kite.step, []

    def step_and_be_set():
        if kite.clock() > 5.0 and not sent:
            sent.append(kite.clock())
            kite.radios[0].emulated.from_station(kite.clock(), frame)
        step()

    kite.step = step_and_be_set
    assert operator.runs("param", "watch", "OUTER_L", "INNER_*", "--every", "2", "--duration", "10") == 0
    lines = operator.said.splitlines()
    assert [line.split()[0] for line in lines[:2]] == ["INNER_P", "OUTER_L"]
    assert len(lines) == 3 and lines[2].endswith("OUTER_L: 5 -> 6.5")


def test_tune_for_a_delay(operator):
    assert operator.runs("tune", "--delay", "0.2", "--json") == 0
    advice = json.loads(operator.said)
    assert (advice["present"], advice["written"], advice["loop_delay_s"]) == (1.5, False, pytest.approx(0.21))
    assert [advice[key] for key in ("limit", "optimum", "sampled_limit", "sampled_optimum")] == pytest.approx(
        [stability_limit(0.2), optimal_gain(0.2), stability_limit(0.21), optimal_gain(0.21)])
    assert operator.kite.firmware_parameter("INNER_P") == 1.5
    assert operator.runs("tune", "--delay", "0.2", "--yes") == 0
    assert operator.kite.firmware_parameter("INNER_P") == float32(optimal_gain(0.2))
    for number in ("0.21 s", "7.854", "7.48", "1.839", "1.752", "acknowledged by the kite"):
        assert number in operator.said
    assert operator.runs("param", "set", "INNER_P", "7.6") == 0
    assert operator.runs("tune", "--delay", "0.2", "--json") == 0
    assert json.loads(operator.said)["verdict"] == "UNSTABLE: above the limit when sampling is included"
    operator.is_told(UsageError, "unstable at 10 Hz", "tune", "--delay", "0.002", "--loop-hz", "10", "--yes")
    operator.is_told(VehicleError, "outside 0.0625 to 50", "tune", "--delay", "0.005", "--loop-hz", "200", "--yes")
    assert operator.kite.firmware_parameter("INNER_P") == float32(7.6)


def test_arm_fly_watch_and_disarm(operator):
    operator.is_told(VehicleError, "mode TRACK: refused by the kite", "mode", "track")
    assert operator.runs("arm") == 0
    assert operator.said == "mode PARK, armed\n"
    assert operator.runs("mode", "track") == 0
    assert operator.runs("monitor", "--duration", "3") == 0
    lines = [line for line in operator.said.splitlines() if "mode=" in line]
    assert len(lines) == 3
    for key in ("mode=TRACK", "armed=yes", "cross_track_deg=", "turning_angle_deg=", "target_deg=", "loss=0.000"):
        assert key in lines[-1]
    with operator.connect() as session:
        session.connection.wait_until(lambda: False, 2.0)
        shown = "\n".join(monitor_view.screen(session, [], 80, 24))
    for word in ("TRACK", "ARMED", "cross-track", "turning angle", "target", "airspeed", "overruns", "samples dropped",
                 "lost 0.0%", "90 % from 1", "last 0.0 s ago", "all is well"):
        assert word in shown
    assert operator.runs("disarm") == 0
    assert operator.runs("mode") == 0
    assert operator.said == "mode STANDBY, disarmed\n"


def test_a_recording_is_what_came_in(operator, tmp_path):
    path = tmp_path / "flight.tlog"
    heard = []
    with operator.connect() as session:
        session.connection.add_observer(lambda time_s, message, frame: heard.append(frame), everyone=True)
        with Recorder(session.connection, path, epoch_offset_s=1.7e9):
            session.connection.wait_until(lambda: False, 5.0)
    records = list(read_tlog(path))
    assert [frame for _, frame in records[1:]] == heard and len(heard) > 100
    assert 4.8e6 < records[-1][0] - records[0][0] < 5.2e6
    with pytest.raises(UsageError, match="already exists"):
        Recorder(session.connection, path, 0.0)
    tool = Path(sysconfig.get_path("scripts")) / "mavlogdump.py"
    dump = subprocess.run([sys.executable, str(tool), "--types", "HEARTBEAT", str(path)],
                          capture_output=True, text=True, check=True).stdout
    assert dump.count("HEARTBEAT") in (4, 5, 6) and "type : 17" in dump
