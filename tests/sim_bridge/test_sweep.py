"""Sweeps: the numbers of single flights, whatever flies them and however often they were stopped."""

import csv
import json
import os
import resource
import signal
import subprocess
import sys
import time
from contextlib import suppress

import pytest

from sim_bridge.cli import main as cli
from sim_bridge.errors import ScenarioError
from sim_bridge.runs.run import RunOptions, run_scenario
from sim_bridge.scenario.scenario import load_scenario
from sim_bridge.sweeps.axes import grid, parse_axis, random_sample
from sim_bridge.sweeps.map_plot import draw_map

SWEEP = ["sweep", "paper-delay-tuned", "--over", "param.INNER_P=1:9:3", "--over", "link.control.delay_s=0.1,0.4",
         "--duration", "12"]


def sweep(*options):
    return cli.main([*SWEEP, "--json", *map(str, options)])


def rows_of(path):
    lines = path.read_text("utf-8").splitlines()
    assert lines[0].startswith("# ")
    return list(csv.DictReader(lines[1:]))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("sweep") / "whole.csv"
    assert sweep("--out", path, "--plot") == 0
    assert path.with_suffix(".png").stat().st_size > 10_000
    return path


def test_a_sweep_flies_what_single_runs_fly(whole):
    rows = rows_of(whole)
    assert [(float(row["param.INNER_P"]), row["link.control.delay_s"]) for row in rows] == [
        (1.0, "0.1"), (1.0, "0.4"), (5.0, "0.1"), (5.0, "0.4"), (9.0, "0.1"), (9.0, "0.4")]
    scenario = load_scenario("paper-delay-tuned")
    for key, value in (("run.duration_s", 12.0), ("link.control.delay_s", 0.4), ("run.seed", 6)):
        scenario.set(key, value, "test")
    scenario.set_parameter("INNER_P", 9.0, "test")
    alone = run_scenario(scenario, RunOptions()).numbers
    assert (rows[5]["seed"], rows[5]["verdict"]) == ("6", "unstable")
    assert float(rows[5]["cross_track_rms_rad"]) == alone["cross_track_rms_rad"]
    assert rows[2]["verdict"] == "tracking"


def test_the_plot_names_parameters_with_their_units_and_shows_the_error_once(whole):
    pytest.importorskip("matplotlib")
    base, rows = load_scenario("paper-delay-tuned"), rows_of(whole)
    gain, delay = parse_axis(SWEEP[3]), parse_axis(SWEEP[5])
    plot, bar = draw_map(base, [gain, delay], rows).axes
    assert (plot.get_xlabel(), plot.get_ylabel()) == ("INNER_P [1/s]", "link.control.delay_s")
    assert bar.get_ylabel() == "cross-track error, RMS [deg]"
    (plot,) = draw_map(base, [gain], rows).axes
    assert (plot.get_xlabel(), plot.get_ylabel()) == ("INNER_P [1/s]", "cross-track error, RMS [deg]")
    assert {"tracking", "unstable"} <= {text.get_text() for text in plot.get_legend().get_texts()}


def killed_in_the_middle(path):
    """What a sweep into `path` that was killed has left there."""
    command = [sys.executable, "-m", "sim_bridge.cli.main", *SWEEP, "--json", "--jobs", "1", "--out", str(path)]
    while True:
        process = subprocess.Popen(command, start_new_session=True, stdout=subprocess.DEVNULL)
        while process.poll() is None and not (path.exists() and path.read_text("utf-8").count("\n") >= 4):
            time.sleep(0.01)
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        there = path.read_text("utf-8")
        if 4 <= there.count("\n") < 8:
            return there
        path.unlink()  # it came to its end before it could be killed: again


def test_a_killed_sweep_goes_on_and_ends_with_the_same_file(whole, tmp_path, capsys):
    path, same_file = tmp_path / "killed.csv", tmp_path / "link.csv"
    cut = killed_in_the_middle(path) + "5,6,0.9"  # a line that was being written
    path.write_text(cut, "utf-8")
    os.link(path, same_file)
    assert sweep("--out", path) == 0
    assert "exist already" in capsys.readouterr().err
    assert path.read_bytes() == whole.read_bytes()
    assert same_file.read_text("utf-8") == cut  # going on never wrote over it: a kill then would have lost nothing


def test_a_sweep_on_a_full_disk_ends_in_a_line_and_goes_on_with_room(whole, tmp_path):
    path = tmp_path / "full.csv"
    room = len(whole.read_bytes()) - 200  # short of the last two runs
    flown = subprocess.run(
        [sys.executable, "-m", "sim_bridge.cli.main", *SWEEP, "--json", "--jobs", "1", "--out", str(path)], check=False,
        capture_output=True, text=True, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (room, room)))
    assert flown.returncode == 2 and not flown.stdout
    assert flown.stderr.splitlines() == [
        f"kite-sitl: {path}: File too large; {len(rows_of(path))} runs are in it; the same command resumes"]
    assert 0 < len(rows_of(path)) < 6 and path.read_bytes().endswith(b"\r\n")
    assert sweep("--out", path) == 0
    assert path.read_bytes() == whole.read_bytes()


def test_runs_of_other_code_are_not_mixed_in_unless_it_is_said(whole, tmp_path, capsys):
    path = tmp_path / "other.csv"
    lines = whole.read_text("utf-8").splitlines(keepends=True)
    code = rows_of(whole)[0]["code"]
    path.write_text("".join(lines[:4]).replace(code, "0123456789ab"), "utf-8")
    before = path.read_bytes()
    assert sweep("--out", path) == 2
    assert "2 of its runs were flown by other code: name another file with --out" in capsys.readouterr().err
    assert path.read_bytes() == before
    assert sweep("--out", path, "--other-code") == 0
    assert "2 of 6 runs exist already, 2 of them by other code" in capsys.readouterr().err
    assert [row["code"] for row in rows_of(path)] == ["0123456789ab"] * 2 + [code] * 4


def test_a_sweep_over_another_wind_of_the_same_name_is_another_sweep(tmp_path, capsys):
    wind, path = tmp_path / "wind.csv", tmp_path / "out.csv"
    command = ["sweep", "paper-no-delay", "--over", "run.seed=1,2", "--set", f"wind.file={wind}", "--duration", "2",
               "--jobs", "1", "--json", "--out", str(path)]
    wind.write_text("time_s,speed_m_s\n0,8\n")
    assert cli.main(command) == 0
    wind.write_text("time_s,speed_m_s\n0,9\n")
    assert cli.main(command) == 2
    assert "holds results of another sweep" in capsys.readouterr().err


def test_a_dask_cluster_gives_the_same_numbers(whole, tmp_path):
    distributed = pytest.importorskip("distributed")
    size = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(host="127.0.0.1", **size) as cluster:
        assert sweep("--out", tmp_path / "dask.csv", "--scheduler", cluster.scheduler_address) == 0
    assert (tmp_path / "dask.csv").read_bytes() == whole.read_bytes()


def test_what_cannot_be_flown_is_a_result(tmp_path):
    path = tmp_path / "narrow.csv"
    assert cli.main(["sweep", "paper-no-delay", "--over", "param.EIGHT_HALF_H=0.5,10", "--param", "TURN_K=0.02",
                     "--duration", "5", "--out", str(path), "--json"]) == 0
    rows = rows_of(path)
    assert rows[0]["verdict"] == "refused" and "kite manages" in rows[0]["trouble"]


def test_a_sample_is_seeded_and_grows_without_moving():
    axes = [parse_axis("param.INNER_P=1:10:2"), parse_axis("link.control.delay_s=0.01:1:2:log"),
            parse_axis("plant.speed_law=glide,constant")]
    sample = random_sample(axes, 400, 7)
    assert random_sample(axes, 40, 7) == sample[:40] and random_sample(axes, 40, 8) != sample[:40]
    gains = sorted(float(values[0]) for values in sample)
    assert 1.0 <= gains[0] < 1.2 and 9.8 < gains[-1] <= 10.0 and gains[200] == pytest.approx(5.5, abs=0.7)
    delays = sorted(float(values[1]) for values in sample)
    assert delays[200] == pytest.approx(0.1, rel=0.4)  # half of them below the geometric mean
    assert {values[2] for values in sample} == {"glide", "constant"}
    assert len(grid(axes)) == 8


@pytest.mark.parametrize("text", ["INNER_P", "a=", "a=1:2", "a=1:x:3", "a=1:2:0", "a=1:2:1", "a=0:2:3:log", "a=1:inf:3",
                                  "a=1:2:3:lin", "a=1:2:3:log:4"])
def test_an_axis_that_cannot_be_read_is_named(text):
    with pytest.raises(ScenarioError, match="--over " + text.split("=", maxsplit=1)[0]):
        parse_axis(text)


def test_another_sweep_does_not_go_into_the_same_file(whole, capsys):
    before = whole.read_bytes()
    assert sweep("--out", whole, "--param", "OUTER_L=3") == 2
    assert "holds results of another sweep" in capsys.readouterr().err
    assert whole.read_bytes() == before


def test_bad_keys_are_refused_before_anything_flies(tmp_path, capsys):
    assert cli.main(["sweep", "small-kite", "--over", "param.INER_P=1,2", "--out", str(tmp_path / "x.csv")]) == 2
    assert "did you mean INNER_P" in capsys.readouterr().err
    assert cli.main([*SWEEP, "--out", str(tmp_path / "x.csv"), "--scheduler", "tcp://127.0.0.1:9"]) in (2,)
    assert "no Dask scheduler there" in capsys.readouterr().err


def test_the_summary_is_for_scripts(whole, capsys):
    assert sweep("--out", whole) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["runs"] == summary["flown"] == 6 and summary["verdicts"]["tracking"] >= 3
