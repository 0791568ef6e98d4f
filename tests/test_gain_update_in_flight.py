"""The whole chain over real UDP: a diverging kite is caught by a ground station that changes one gain in flight."""

import csv
import math
import socket
import subprocess
import sys
from typing import Any

import numpy as np

from ground.cli.main import main as kite_ground
from kite_analysis.delay.inner_loop import optimal_gain
from kite_analysis.flights.tlog import read_tlog
from protocol import dialect
from protocol.single_precision import float32


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def acknowledged_at(folder):
    """Flight time at which the new gain was acknowledged, from the log of the ground path."""
    parser = dialect.MAVLink(None)
    first = next(stamp for stamp, _ in read_tlog(folder / "control.tlog"))
    for stamp, frame in read_tlog(folder / "ground.tlog"):
        message: Any = parser.decode(bytearray(frame))
        if message.get_type() == "PARAM_VALUE" and (message.param_id, message.param_value) == (
                "INNER_P", float32(optimal_gain(0.2))):
            return (stamp - first) * 1e-6 - 2.1  # the log begins with the lead-in: 2 s and the samples' delay
    raise AssertionError("the gain was never acknowledged")


def test_tune_turns_a_diverging_flight_into_a_tracking_one(tmp_path, capsys):
    port = free_port()
    folder = tmp_path / "log"
    command = [
        sys.executable, "-m", "sim_bridge.cli.main", "run", "paper-delay", "--runtime", "cpython", "--speed", "6",
        "--ground", "--set", f"ground.send_to=127.0.0.1:{port}", "--set", "ground.listen=127.0.0.1:0",
        "--duration", "70", "--status", "--log", str(folder)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as sitl:
        assert sitl.stdout
        for line in sitl.stdout:
            if " 15 s  TRACK" in line:
                break
        assert kite_ground(["--link", f"udpin:127.0.0.1:{port}", "tune", "--delay", "0.2", "--yes"]) == 0
        assert "1.839" in capsys.readouterr().out
        assert "log:" in sitl.communicate()[0]
    assert sitl.returncode == 0

    changed = acknowledged_at(folder)
    assert 15.0 <= changed < 40.0
    with (folder / "truth.csv").open() as file:
        rows = [{name: float(text) for name, text in row.items()} for row in csv.DictReader(file)]
    columns = ("time_s", "course_rad", "target_course_rad", "cross_track_rad")
    time_s, course, target, cross_track = (np.array([row[name] for row in rows]) for name in columns)
    error = (target - course + math.pi) % (2 * math.pi) - math.pi

    def rms(values, start_s, end_s):
        return float(np.sqrt(np.mean(values[(time_s >= start_s) & (time_s < end_s)] ** 2)))

    assert rms(error, 5.0, changed) > 1.2  # diverging
    assert rms(error, changed + 20.0, 70.0) < 0.5  # tracking
    assert rms(cross_track, changed + 20.0, 70.0) < 0.10
