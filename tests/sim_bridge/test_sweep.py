"""Sweeps: the numbers of single flights, whatever flies them and however often they were stopped."""

import csv
import json
import os
import signal
import subprocess
import sys
import time

import pytest

from sim_bridge import cli
from sim_bridge.run import RunOptions, run_scenario
from sim_bridge.scenario import ScenarioError, load_scenario
from sim_bridge.sweeps.axes import grid, parse_axis, random_sample

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


def test_a_killed_sweep_goes_on_and_ends_with_the_same_file(whole, tmp_path, capsys):
    path = tmp_path / "killed.csv"
    command = [sys.executable, "-m", "sim_bridge.cli", *SWEEP, "--json", "--jobs", "1", "--out", str(path)]
    process = subprocess.Popen(command, start_new_session=True)
    while not path.exists() or path.read_text("utf-8").count("\n") < 4:
        assert process.poll() is None, "it ended before it could be killed"
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    there = path.read_text("utf-8")
    assert 4 <= there.count("\n") < 8
    path.write_text(there + "5,6,0.9", "utf-8")  # a line that was being written
    assert sweep("--out", path) == 0
    assert "are there already" in capsys.readouterr().err
    assert path.read_bytes() == whole.read_bytes()


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
    assert rows[0]["verdict"] == "refused" and "kite only in" in rows[0]["trouble"]


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
    assert "holds something else" in capsys.readouterr().err
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
