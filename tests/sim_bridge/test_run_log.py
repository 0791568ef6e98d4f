"""Run logs: written as the flight goes, whole whenever it ends, and flown again by whoever has them."""

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from kite_analysis.flights.reader import read_record
from kite_analysis.flights.tlog import read_tlog
from protocol import dialect
from protocol.contract import CONTRACT_HASH
from protocol.parameter_table import load_parameters
from sim_bridge.cli.main import main
from sim_bridge.flight import flight
from sim_bridge.flight.truth_columns import COLUMNS
from sim_bridge.runs import growing_files, run_log
from sim_bridge.runs.run import RunOptions, run_scenario
from sim_bridge.runtimes.memory import MemoryRuntime
from sim_bridge.scenario.keys import KEYS
from sim_bridge.scenario.scenario import load_scenario
from tests.sim_bridge.killed_flights import FlightProcess, opens_everywhere, repeats

ROOT = Path(__file__).parents[2]


def scenario(name="small-kite", duration_s=1.2):
    made = load_scenario(name)
    made.set("run.duration_s", duration_s, "test")
    made.set("sensors.noise_rad", 0.001, "test")
    return made


def fly(folder, duration_s=1.2, **options):
    told = []
    result = run_scenario(scenario(duration_s=duration_s), RunOptions(log=folder, **options), notice=told.append)
    return result, told


def rerun(capsys, folder) -> tuple[int, dict[str, Any], str]:
    """Exit code, result and what was said."""
    code = main(["rerun", str(folder), "--json"])
    out, err = capsys.readouterr()
    return code, json.loads(out) if out else {}, err


def test_a_flight_whose_bridge_is_killed_is_there_up_to_the_last_second(tmp_path, capsys):
    killed = FlightProcess(tmp_path / "log", "--forever", "--speed", "8")
    killed.fly_until(9.0)
    firmware = killed.firmware()
    killed.process.kill()
    killed.end()
    os.kill(firmware, signal.SIGKILL)
    repeats(killed.folder, capsys, killed.shown_s - 1.0)
    opens_everywhere(killed.folder, capsys)


def test_a_flight_whose_firmware_dies_keeps_its_log(tmp_path, capsys):
    killed = FlightProcess(tmp_path / "log", "--forever", "--speed", "8")
    killed.fly_until(9.0)
    os.kill(killed.firmware(), signal.SIGKILL)
    code, said = killed.end()
    kept, why = said.splitlines()
    assert code == 2 and why.startswith("kite-sitl: the firmware ended in tick ")
    assert kept.startswith(f"kite-sitl: log: {killed.folder}, up to ")
    about = json.loads((killed.folder / "run.json").read_text())
    assert about["ended"] == why.removeprefix("kite-sitl: ") and not about["interrupted"]
    repeats(killed.folder, capsys, killed.shown_s)
    opens_everywhere(killed.folder, capsys)


def flown_until_interrupted(folder, stop_at):
    """Fly with a KeyboardInterrupt at that line of flight or log, as a signal raises it; return lines left to go."""
    files = {module.__file__ for module in (flight, growing_files, run_log)}
    left = stop_at

    def trace(frame, event, _):
        nonlocal left
        if frame.f_code.co_filename not in files:
            return None
        if event == "line":
            left -= 1
            if not left:
                raise KeyboardInterrupt
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        run_scenario(scenario(duration_s=0.8), RunOptions(log=folder), notice=lambda _: None)
    except KeyboardInterrupt:
        pass
    finally:
        sys.settrace(before)
    return left


def test_ctrl_c_at_any_moment_leaves_a_log_that_repeats(tmp_path, capsys):
    lines = 10**9 - flown_until_interrupted(tmp_path / "whole", 10**9)
    in_flight = round(0.75 * lines)  # the preflight takes longer than the flight
    reruns = 0
    for stop_at in [*range(3, in_flight, in_flight // 5), *range(in_flight, lines, (lines - in_flight) // 31)]:
        folder = tmp_path / str(stop_at)
        flown_until_interrupted(folder, stop_at)
        if not (folder / "run.json").exists():
            assert stop_at < in_flight
            continue
        code, result, said = rerun(capsys, folder)
        if code == 2:
            assert said.endswith("the log ends before the flight began: nothing to fly again\n"), said
        else:
            reruns += 1
            assert code == 0 and result["same"], (stop_at, result, said)
    assert reruns > 20


@pytest.mark.parametrize("room", [300, 40_000, 90_000])
def test_a_full_disk_ends_the_log_and_not_the_flight(tmp_path, capsys, room):
    folder = tmp_path / "log"
    flown = subprocess.run(
        [sys.executable, "-m", "sim_bridge.cli.main", "run", "small-kite", "--duration", "20", "--log", str(folder),
         "--json"], check=False, capture_output=True, text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (room, room)))
    if room == 300:  # full before the flight, which is then not begun
        assert flown.returncode == 2
        assert flown.stderr == f"kite-sitl: --log {folder}: File too large\n"
        return
    assert flown.returncode == 0 and json.loads(flown.stdout)["ticks"] == 1000
    assert flown.stderr.startswith(f"kite-sitl: log {folder}: File too large: the flight goes on, but nothing after ")
    assert len(flown.stderr.splitlines()) == 1
    about = json.loads((folder / "run.json").read_text())
    assert about["log_ended"] == "File too large" and about["result"]["ticks"] == 1000
    code, result, _ = rerun(capsys, folder)
    assert code == 0 and result["same"] and 0.4 < result["until_s"] < 9.0 and result["cut"]
    assert list(read_tlog(folder / "control.tlog"))


@pytest.mark.parametrize("theirs", ["notes.txt", "run.json"])
def test_a_folder_that_holds_anything_is_refused_and_left_alone(tmp_path, capsys, theirs):
    (tmp_path / theirs).write_text("{}")
    assert main(["run", "small-kite", "--log", str(tmp_path)]) == 2
    assert capsys.readouterr().err == f"kite-sitl: --log {tmp_path}: not empty; give a new folder\n"
    assert [path.name for path in tmp_path.iterdir()] == [theirs] and (tmp_path / theirs).read_text() == "{}"


def test_run_json_holds_every_value_that_decides_the_flight(tmp_path):
    wind = tmp_path / "gusty.csv"
    wind.write_text("time_s,speed_m_s\n0,8\n30,9\n")
    made = scenario()
    made.set("wind.file", str(wind), "test")
    run_scenario(made, RunOptions(log=tmp_path / "log"), notice=lambda _: None)
    about = json.loads((tmp_path / "log" / "run.json").read_text())
    assert about["scenario"]["values"].keys() == KEYS.keys()
    assert about["scenario"]["parameters"].keys() == {
        name for name, entry in load_parameters().items() if not entry.read_only}
    assert about["versions"]["contract"] == CONTRACT_HASH and about["versions"]["numpy"]
    assert about["code"].keys() == {"firmware_py", "protocol", "sim_bridge", "kite_analysis"}
    assert (tmp_path / "log" / "wind.csv").read_bytes() == wind.read_bytes() and about["wind_file"]


def test_the_wind_of_then_blows_in_a_rerun(tmp_path, capsys):
    wind = tmp_path / "gusty.csv"
    wind.write_text("time_s,speed_m_s\n0,8\n1,9\n")
    folder = tmp_path / "log"
    assert main(["run", "v3-flight", "--set", f"wind.file={wind}", "--duration", "2", "--log", str(folder),
                 "--json"]) == 0
    wind.write_text("time_s,speed_m_s\n0,8\n1,12\n")
    capsys.readouterr()
    assert rerun(capsys, folder)[0] == 0
    (folder / "wind.csv").unlink()
    code, _, said = rerun(capsys, folder)
    assert code == 2
    assert said == f"kite-sitl: {folder}: its wind.csv, the wind of this flight, is missing or was changed\n"


def test_another_version_flies_the_values_of_the_log_and_says_what_differs(tmp_path):
    """A copy of the project with two other defaults reruns a log of this one."""
    folder, other = tmp_path / "log", tmp_path / "other"
    fly(folder)
    for package in ("kite_analysis", "firmware_py", "ground", "protocol", "sim_bridge"):
        shutil.copytree(ROOT / package, other / package, ignore=shutil.ignore_patterns("__pycache__"))
    line = other / "sim_bridge" / "plants" / "tether_settings.py"
    table = other / "protocol" / "parameters.toml"
    changed = line.read_text().replace("number(0.01,", "number(0.005,")
    assert changed != line.read_text()
    line.write_text(changed)
    before, name, after = table.read_text().partition('[FF_FILTER]\n')
    assert name
    table.write_text(before + name + after.replace("default = 0.125", "default = 0.25", 1))
    again = subprocess.run([sys.executable, "-m", "sim_bridge.cli.main", "rerun", str(folder), "--json"], cwd=other,
                           check=False, capture_output=True, text=True)
    assert again.returncode == 0, again.stderr
    result = json.loads(again.stdout)
    assert result["same"]
    assert "flown by other code: protocol, sim_bridge differ" in result["differs"]
    assert "plant.step_s: the default was 0.01, is 0.005; flown with 0.01, as logged" in result["differs"]
    assert "FF_FILTER: the default was 0.125, is 0.25; flown with 0.125, as logged" in result["differs"]
    assert [f"kite-sitl: {line}" for line in result["differs"]] == again.stderr.splitlines()


def test_settings_that_came_after_a_log_are_told_in_a_line_and_flown_with_their_defaults(tmp_path, capsys):
    folder = tmp_path / "log"
    fly(folder, duration_s=5.0)
    about = json.loads((folder / "run.json").read_text())
    for table in (about["scenario"]["values"], about["defaults"]["values"]):
        for name in [name for name in table if name.startswith("errors.")]:
            del table[name]
    (folder / "run.json").write_text(json.dumps(about))
    _, result, _ = rerun(capsys, folder)
    assert result["same"]
    assert result["differs"] == ["new since, and flown with their defaults: errors.position.noise to "
                                 "errors.steering.dropout_s (56)"]


def test_a_changed_truth_is_noticed_and_a_missing_one_said(tmp_path, capsys):
    folder = tmp_path / "log"
    fly(folder, duration_s=10.0)
    truth = folder / "truth.csv"
    rows = truth.read_text().splitlines(keepends=True)
    places = [len(rows[400]) - 30, len(rows[400]) - 5]  # between two commas, and in the last number
    for cut_at in places:
        truth.write_text("".join(rows[:400]) + rows[400][:cut_at])
        code, result, _ = rerun(capsys, folder)
        assert code == 0 and result["same"] and result["ticks"] == 399 and result["cut"]
        assert len(read_record(folder).time_s) == 399
    truth.unlink()
    code, _, said = rerun(capsys, folder)
    assert code == 2 and said == f"kite-sitl: {truth} is missing: no record of the flight\n"


class Stations:
    """A ground path: a flood of `size` bytes a tick from tick 20 on, in which a gain is moved."""

    def __init__(self, size):
        self._size = size

    def to_firmware(self, time_s):
        tick = round(time_s * 50)
        if tick < 20:
            return []
        station = dialect.MAVLink(None, 250, 190)
        gain = dialect.MAVLink_param_set_message(1, 1, b"OUTER_L", 4.0 + tick % 2, dialect.MAV_PARAM_TYPE_REAL32)
        return [gain.pack(station), *[bytes([tick % 250, i % 250]) * 500 for i in range(self._size // 1000)]]

    def from_firmware(self, time_s, frames):
        pass

    def to_stations(self, time_s):
        return []


def flown_with_stations(folder, size, duration_s=2.0):
    told = []
    run_scenario(scenario(duration_s=duration_s), RunOptions(log=folder), Stations(size), MemoryRuntime(), told.append)
    about = json.loads((folder / "run.json").read_text())
    (folder / "run.json").write_text(json.dumps(about | {"runtime": "cpython"}))  # `memory` is for tests alone
    return told


def test_what_ground_stations_sent_is_flown_again_up_to_where_it_is_known(tmp_path, capsys):
    folder = tmp_path / "log"
    assert not flown_with_stations(folder, 0)
    code, result, _ = rerun(capsys, folder)
    assert code == 0 and result["same"] and result["ticks"] == 100 and not result["cut"]
    sent = folder / "ground_input.txt"
    text = sent.read_text()
    sent.write_text(text[: len(text) * 2 // 3])
    code, result, _ = rerun(capsys, folder)
    assert code == 0 and result["same"] and 40 < result["ticks"] < 80
    assert result["cut"] == "ground-station input is not recorded beyond it"
    sent.unlink()
    code, _, said = rerun(capsys, folder)
    assert code == 2
    assert said == f"kite-sitl: {sent} is missing: no record of what ground stations sent\n"


def test_a_flood_fills_no_disk_and_the_log_says_what_it_lacks(tmp_path, capsys):
    folder = tmp_path / "log"
    told = flown_with_stations(folder, 40_000, 4.0)  # 2 MB/s
    assert len(told) == 1 and "ground stations send more than 1 MB and 10 kB/s" in told[0]
    assert (folder / "ground_input.txt").stat().st_size < 2.3e6
    assert json.loads((folder / "run.json").read_text())["ground_bytes_left_out"] > 4e6
    code, result, _ = rerun(capsys, folder)
    assert code == 0 and result["same"] and 0.5 < result["until_s"] < 2.0
    assert f"a rerun repeats up to {result['until_s']:.1f} s" in told[0]


def test_a_log_with_a_limit_keeps_its_newest_part(tmp_path, capsys):
    folder = tmp_path / "log"
    fly(folder, duration_s=60.0, log_limit_mb=0.4)
    sizes = {path.name: path.stat().st_size for path in folder.iterdir()}
    assert {"truth.old.csv", "control.old.tlog"} <= sizes.keys()
    assert sum(sizes.values()) - sizes["run.json"] < 0.45e6
    rows = (folder / "truth.csv").read_text().splitlines()
    assert rows[0] == ",".join(COLUMNS) and float(rows[-1].split(",")[0]) == pytest.approx(59.98)
    code, result, _ = rerun(capsys, folder)
    assert code == 0 and result["same"] and result["ticks"] == 3000
