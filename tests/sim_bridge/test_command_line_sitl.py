"""kite-sitl as a person and a script use it."""

import gzip
import json
import socket
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from kite_analysis.flights.tlog import read_tlog
from protocol import dialect
from sim_bridge.cli.main import main

KEYS = {
    "scenario", "plant", "runtime", "loop", "seed", "sim_s", "wall_s", "real_time_factor", "cross_track_rms_rad",
    "cross_track_max_rad", "turning_angle_rms_rad", "steering_rms", "saturated_fraction", "verdict", "trouble", "ticks",
    "overruns", "steering_travel_per_s", "steering_asked_travel_per_s", "peak_tether_force_n",
    "least_elevation_rad",
}
FLIGHTS = Path(__file__).parent.parent / "data" / "flight"


def run(capsys, *arguments):
    """Exit code, and what was said on stdout and stderr."""
    try:
        code: Any = main(arguments)
    except SystemExit as exit_:  # argparse's own
        code = exit_.code
    out, err = capsys.readouterr()
    return code, out, err


def test_json_has_the_names_that_scripts_rely_on(capsys):
    code, out, err = run(capsys, "run", "paper-delay-tuned", "--duration", "12", "--json", "--param", "INNER_P=2",
                         "--set", "plant.turn_k=2.5", "--seed", "7")
    numbers = json.loads(out)
    assert code == 0 and not err and set(numbers) == KEYS
    assert (numbers["seed"], numbers["sim_s"], numbers["ticks"]) == (7, pytest.approx(12.0), 600)


def test_list_and_keys_and_help_teach(capsys):
    assert "paper-delay-tuned" in run(capsys, "list")[1]
    assert "link.control.jitter_s" in run(capsys, "keys")[1]
    for verb in ("run", "rerun", "paper", "shadow", "bench"):
        code, out, _ = run(capsys, verb, "--help")
        assert code == 0 and "usage: kite-sitl" in out


def test_bad_input_is_one_line_and_exit_code_2(capsys, tmp_path):
    broken = tmp_path / "broken.toml"
    broken.write_text("[plant\n")
    no_columns = tmp_path / "flight.csv"
    no_columns.write_text("time,kite_azimuth\n0,1\n")
    words = tmp_path / "words.csv"
    with gzip.open(FLIGHTS / "20191008_0065.csv.gz", "rt") as file:
        header, row = file.readline(), file.readline()
    words.write_text(header + row + row.replace("pp-ri", "x").replace(row.split(",")[0], "noon"))
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").write_text("x")
    cases = {
        ("run", "paper-dealy"): "did you mean paper-delay?",
        ("run", "paper-delay", "--set", "plant.trun_k=1"): "did you mean plant.turn_k?",
        ("run", "paper-delay", "--set", "plant.turn_k"): "write section.key=value",
        ("run", "paper-delay", "--set", "link.control.loss=2"): "outside 0 to 1",
        ("run", "paper-delay", "--param", "INNER_P=x"): "'x' is not a number",
        ("run", "paper-delay", "--param", "INNER_P=99"): "INNER_P = 99 is outside 0.0625 to 50 1/s",
        ("run", str(broken)): "broken TOML",
        ("run", str(tmp_path / "none.toml")): "No such file",
        ("run", "paper-delay", "--ground", "--runtime", "inproc"): "--runtime cpython",
        ("run", "paper-delay", "--log", str(tmp_path / "full")): "not empty",
        ("run", "paper-delay", "--param", "EIGHT_HALF_H=1"): "eight needs",
        ("run", "paper-delay", "--duration", "1", "--plot", str(tmp_path / "x.nonsense")): "nonsense",
        ("rerun", str(tmp_path)): "not a run log",
        ("shadow", str(tmp_path / "none.csv")): "No such file",
        ("shadow", str(no_columns)): "column kite_elevation is missing",
        ("shadow", str(words)): "line 3, column time: 'noon' is not a number",
        ("paper", "--out", str(broken / "x")): "--out",
    }
    for arguments, says in cases.items():
        code, _, err = run(capsys, *arguments)
        lines = err.strip().splitlines()
        assert code == 2 and says in lines[-1], (arguments, err)
        assert len(lines) == 1 and lines[0].startswith("kite-sitl: "), err


def test_a_port_in_use_is_said_before_anything_flies(capsys):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        taken = f"127.0.0.1:{other.getsockname()[1]}"
        code, _, err = run(capsys, "run", "paper-delay", "--runtime", "cpython", "--ground",
                           "--set", f"ground.listen={taken}")
    assert code == 2 and taken in err and "Address already in use" in err


@pytest.mark.parametrize("runtime", ["inproc", "cpython"])
def test_a_logged_run_flies_again_to_the_bit_and_a_changed_log_is_noticed(capsys, tmp_path, runtime):
    folder = tmp_path / "log"
    noise = ["--set", "sensors.noise_rad=0.001", "--set", "link.control.jitter_s=0.03", "--duration", "8"]
    assert run(capsys, "run", "small-kite", "--runtime", runtime, "--log", str(folder), *noise)[0] == 0
    code, out, _ = run(capsys, "rerun", str(folder), "--json")
    assert code == 0 and json.loads(out)["same"]
    truth = folder / "truth.csv"
    lines = truth.read_text().splitlines()
    lines[100] = lines[100].replace(lines[100].split(",")[1], "0.123")
    truth.write_text("\n".join(lines) + "\n")
    code, out, _ = run(capsys, "rerun", str(folder))
    assert code == 1 and "NOT the same: tick 99, azimuth_rad" in out


def test_the_log_holds_the_frames_of_the_control_path(tmp_path, capsys):
    folder = tmp_path / "log"
    run(capsys, "run", "paper-delay-tuned", "--duration", "4", "--log", str(folder))
    parser = dialect.MAVLink(None)
    kinds: dict[str, list[float]] = {}
    for stamp, frame in read_tlog(folder / "control.tlog"):
        kinds.setdefault(parser.decode(bytearray(frame)).get_type(), []).append(stamp * 1e-6)
    for kind in ("KITE_SENSORS", "HIL_ACTUATOR_CONTROLS", "KITE_STATE"):
        flown = [stamp for stamp in kinds[kind] if stamp >= kinds["HIL_ACTUATOR_CONTROLS"][-1] - 3.99]
        assert len(flown) == 200
    assert {"PARAM_VALUE", "COMMAND_ACK", "HEARTBEAT", "STATUSTEXT"} <= set(kinds)


def test_plots_are_written(capsys, tmp_path):
    flight, shadow = tmp_path / "flight.png", tmp_path / "shadow.svg"
    assert run(capsys, "run", "paper-no-delay", "--duration", "20", "--plot", str(flight))[0] == 0
    data = flight.read_bytes()
    assert data[:4] == b"\x89PNG" and min(struct.unpack(">II", data[16:24])) > 500
    assert run(capsys, "shadow", str(FLIGHTS / "20191008_0065.csv.gz"), "--plot", str(shadow))[0] == 0
    assert "CC-BY" in shadow.read_text() or "Kitepower" in shadow.read_text()


def test_paper_makes_seven_figures_and_the_table(capsys, tmp_path):
    assert run(capsys, "paper", "--out", str(tmp_path / "figures"))[0] == 0
    assert len(list((tmp_path / "figures").glob("*.png"))) == 7
    rows = (tmp_path / "figures" / "numbers.csv").read_text().splitlines()
    assert [row.split(",")[:2] for row in rows[1:]] == [
        ["paper-no-delay", "tracking"], ["paper-delay", "unstable"], ["paper-delay-tuned", "tracking"]]


def test_ctrl_c_and_the_end_of_a_pipe_leave_no_traceback():
    """A flight that is interrupted sums up what there is."""
    command = [sys.executable, "-m", "sim_bridge.cli.main", "run", "paper-no-delay", "--forever", "--status",
               "--set", "run.settle_s=1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout and process.stderr
        for _ in range(3):
            assert "TRACK" in process.stdout.readline()
        process.terminate()
        rest, said = process.communicate()
    assert process.returncode == 0 and "interrupted" in rest and "tracking: cross-track" in rest
    assert said == ""
