"""Pictures: one rule in both commands, and what is wrong is said before anything is flown or computed."""

import os
import pty
import subprocess
import sys
import termios
from pathlib import Path

import pytest

from ground.cli.main import main as kite_ground
from sim_bridge.cli.main import main as kite_sitl

pytest.importorskip("matplotlib")
FLIGHT = str(Path(__file__).parent.parent / "data" / "flight" / "20191008_0065.csv.gz")
DESIGN = ("design", "--delay", "0.2", "--speed-over-length", "0.45")
SWEEP = ("sweep", "paper-delay-tuned", "--over", "param.INNER_P=2,3", "--duration", "12", "--jobs", "1")
RUN = ("run", "paper-delay-tuned", "--duration", "3")


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty working directory, with a recorded flight beside it."""
    monkeypatch.chdir(tmp_path)
    assert kite_sitl(["run", "paper-delay-tuned", "--duration", "12", "--log", "flight"]) == 0
    return tmp_path


def test_every_command_that_draws_asks_before_it_works_and_writes_over_nothing(here, capsys):
    """The files that are there hold a user's words; each command is asked for these very files, and for no picture."""
    drawers = {
        RUN: "paper-delay-tuned.png", DESIGN: "design.png", ("identify", "flight"): "flight-identify.png",
        ("shadow", FLIGHT): "20191008_0065-shadow.png", SWEEP: "paper-delay-tuned-sweep.png",
    }
    for words, name in drawers.items():
        (here / name).write_text("mine")
        for arguments, says in (
            ((*words, "--plot"), f"{name}: already exists: give another name, or --force"),
            ((*words, "--plot", "x.nonsense"), "x.nonsense: the name of a plot must end in .png, .svg, .pdf or .jpg"),
            ((*words, "--plot", f"{name}/x.png"), "is not a folder"),
        ):
            capsys.readouterr()
            assert kite_sitl(arguments) == 2, arguments
            out, error = capsys.readouterr()
            assert out == "" and says in error and error.count("\n") == 1, error
        assert (here / name).read_text() == "mine"
        assert kite_sitl([*words, "--plot", "--force"]) == 0
        assert (here / name).read_bytes()[:4] == b"\x89PNG"
    assert kite_sitl([*SWEEP, "--plot"]) == 0  # a sweep that goes on draws its own map again
    for out, says in (("flight-identify.png", "already exists"), ("x.txt", "must end in .png, .svg, .pdf or .jpg")):
        assert kite_ground(["plot", "flight/control.tlog", "--out", out]) == 2
        assert says in capsys.readouterr().err
    assert kite_ground(["plot", "flight/control.tlog", "--out", "flight-identify.png", "--force"]) == 0


def test_the_paper_and_a_run_log_are_not_begun_either(here, capsys):
    (here / "figures").mkdir()
    (here / "figures" / "trajectory-D200L5Popt.png").write_text("mine")
    assert kite_sitl(["paper", "--out", "figures"]) == 2
    assert len(list((here / "figures").iterdir())) == 1
    assert kite_sitl([*RUN, "--log", "mine", "--plot", "x.nonsense"]) == 2
    assert not (here / "mine").exists()


def test_plot_leaves_the_scenario_and_the_flight_to_their_verbs(here, capsys):
    (here / "mine.toml").write_text('title = "mine"\n')
    for words, name in ((["run", "--duration", "3", "--plot", "paper-delay"], "paper-delay.png"),
                        (["run", "--duration", "3", "--plot", "mine.toml"], "mine.png"),
                        (["identify", "--plot", "flight"], "flight-identify.png"),
                        (["run", "--duration", "3", "--log", "log", "--plot", "paper-delay"], "log/paper-delay.png"),
                        (["run", "--duration", "3", "--plot", "as/asked.JPG", "paper-delay"], "as/asked.JPG")):
        assert kite_sitl(words) == 0, words
        assert (here / name).read_bytes()[:3] in (b"\x89PN", b"\xff\xd8\xff")


def on_a_terminal(*arguments: str) -> tuple[str, str]:
    """What kite-sitl says on its output, a pipe, and what it draws on a terminal of its own."""
    ours, theirs = pty.openpty()
    termios.tcsetwinsize(theirs, (24, 80))
    with subprocess.Popen([sys.executable, "-m", "sim_bridge.cli.main", *arguments],
                          stdout=subprocess.PIPE, stderr=theirs, text=True) as process:
        os.close(theirs)
        out, _ = process.communicate()
    assert process.returncode == 0
    drawn = b""
    try:
        while data := os.read(ours, 65536):
            drawn += data
    except OSError:  # the other side is closed
        pass
    os.close(ours)
    return out, drawn.decode()


def test_a_flight_shows_how_far_it_is_on_a_terminal_only():
    """At 4 times real time, so that it lasts longer than the second after which a bar appears."""
    flight = ("run", "paper-delay-tuned", "--duration", "6", "--speed", "4")
    out, drawn = on_a_terminal(*flight)
    assert "of 6 s flown" in drawn and "of 6 s" not in out
    assert on_a_terminal(*flight, "--json")[1] == ""
    done = subprocess.run([sys.executable, "-m", "sim_bridge.cli.main", *flight], capture_output=True, text=True,
                          check=True)
    assert done.stderr == ""
