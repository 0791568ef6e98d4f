"""The picture of a recorded flight: what is drawn is what was flown."""

import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.cli.main import main
from ground.logs.plot import flight_of, plot_log
from ground.logs.reader import MessageLog, read_message_log
from ground.logs.sky import View
from kite_analysis.figure_eight import TargetEight, great_circle_distance, unit_position
from tests.ground.recorded_flights import record

pytest.importorskip("matplotlib")
angles = st.floats(-1.4, 1.4)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("flights")


@pytest.fixture
def flight(flying_kite, folder) -> MessageLog:
    """Over a link of 0.1 s there and back that loses 10 % each way."""
    path = folder / "flight.tlog"
    return read_message_log(path) if path.exists() else record(flying_kite("paper-delay-tuned", loss=0.1), path)


def lines(axes) -> dict[str, np.ndarray]:
    """The values of the lines with a name in the legend."""
    return {line.get_label(): np.asarray(line.get_ydata(), float) for line in axes.lines
            if not line.get_label().startswith("_")}


def test_what_is_drawn_is_what_was_flown(flight):
    figure = plot_log(flight_of(flight, flight.vehicle(), 0.0, flight.duration_s))
    sky, angle, steering, delay, loss = figure.axes[:5]
    assert {"flown", "target", "start"} <= set(lines(sky))
    course = np.radians(lines(angle)[r"flown $\theta$"])
    sent = [entry.message for entry in flight.messages if entry.message.get_type() == "KITE_STATE"]
    drawn = course[np.isfinite(course)]
    assert np.exp(1j * drawn) == pytest.approx(np.exp(1j * np.array([state.course for state in sent])))
    assert np.abs(np.diff(drawn)).max() < 1.0
    commanded = lines(steering)["commanded"]
    peak = np.nanmax(np.abs(commanded))
    assert 0.01 < peak < 0.25 and peak < steering.get_ylim()[1] < 0.5
    assert lines(steering)["limits, off the scale at ±1"].max() == 1.0
    assert 100.0 <= np.median(lines(delay)["round trip"]) <= 140.0
    lost = loss.collections[0].get_paths()[0].vertices[:, 1].max()
    assert 5.0 < lost < 25.0
    written = {text.get_text().strip() for axes in figure.axes for text in axes.texts}
    assert any(text.startswith("INNER_P") and text.endswith("→ 2.5") for text in written)
    assert "TRACK" in written and "PARK" in written
    figure.draw_without_rendering()
    modes = [text.get_window_extent() for text in angle.texts if text.get_text().strip() in ("TRACK", "PARK")]
    assert modes and not any(box.overlaps(angle.get_legend().get_window_extent()) for box in modes)


@pytest.mark.parametrize("name", ["flight.png", "flight.svg"])
def test_the_command_draws_it(flight, tmp_path, capsys, name):
    out = tmp_path / name
    assert main(["plot", str(flight.path), "--out", str(out), "--from", "2", "--to", "9"]) == 0
    output = capsys.readouterr()
    assert output.out == f"{out} drawn\n" and output.err == ""
    assert out.read_bytes()[:4] == (b"\x89PNG" if name.endswith("png") else b"<?xm")


def test_what_cannot_be_drawn_is_answered_in_one_line(flight, tmp_path, capsys, monkeypatch):
    def is_told(said: str, *arguments: str) -> None:
        assert main(["plot", str(flight.path), *arguments]) == 2
        error = capsys.readouterr().err
        assert said in error and error.count("\n") == 1

    is_told("the name of a plot must end in .png, .svg, .pdf or .jpg", "--out", str(tmp_path / "flight.txt"))
    is_told("nothing of it is from 99 to", "--from", "99")
    is_told("'soon' is not a number", "--from", "soon")
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    is_told("plots need matplotlib: pip install", "--out", str(tmp_path / "flight.png"))


@given(centre=st.tuples(angles, st.floats(0.1, 1.4)), point=st.tuples(angles, st.floats(0.0, 1.5)))
def test_on_the_drawn_sky_distances_from_the_centre_are_true(centre, point):
    view = View(TargetEight(centre[0], centre[1], 0.5, 0.2), np.zeros(1), np.zeros(1))
    right, up = view.project(np.array([point[0]]), np.array([point[1]]))
    true = great_circle_distance(*(unit_position(np.array([at[0]]), np.array([at[1]])) for at in (centre, point)))
    assert np.radians(np.hypot(right, up)) == pytest.approx(true, abs=1e-7)
    assert view.project(np.array([centre[0] - 0.1]), np.array([centre[1]]))[0] > 0.0  # -y is to the right
