"""The paper's seven figures and a table of their numbers, from flights of this project on any of its plants.

J. H. Baayen, "Trajectory tracking control of kites with system delay" (2012), section 5.
"""

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from kite_analysis.delay.inner_loop import optimal_gain
from kite_analysis.figures import new_figure, save
from kite_analysis.picture_file import check_new_file, check_picture
from kite_analysis.plots import draw_lambert_w, draw_trajectory, draw_turning_angle
from sim_bridge.runs.run import RunOptions, RunResult, run_scenario
from sim_bridge.scenario.scenario import Scenario, load_scenario

# Delay of the paper's flights by plant [s]. All have P = 10 1/s and L = 5, but own lines, eights and constants K.
_DELAY_S = {"turning-rate": 0.2, "one-point": 0.2, "four-point": 0.3, "vortex-lattice": 0.2}
_COLUMNS = ("scenario", "verdict", "cross_track_rms_rad", "cross_track_max_rad", "turning_angle_rms_rad",
            "steering_rms", "saturated_fraction")
_FIGURES = ("trajectory", "turning-angle")
_ANGLE_WINDOW_S = 40.0


class PaperFlight(NamedTuple):
    """One of the three: its scenario, the label of the paper's figures, and a title in TeX."""

    scenario: Scenario
    label: str
    title: str


def paper_flights(plant: str) -> list[PaperFlight]:
    """Without delay; with it and the same gains; with it and P = 1 / (e tau). The first has a scenario file."""
    delay_s = _DELAY_S[plant]
    ending = "" if plant == "turning-rate" else f"-{plant}"
    flights = []
    for name, delay, gain, label, title in (
        ("no-delay", 0.0, None, "D0L5P10", r"$\tau = 0$ s, $L = 5$, $P = 10$"),
        ("delay", delay_s, None, f"D{1000 * delay_s:.0f}L5P10", rf"$\tau = {delay_s:g}$ s, $L = 5$, $P = 10$"),
        ("delay-tuned", delay_s, optimal_gain(delay_s), f"D{1000 * delay_s:.0f}L5Popt",
         rf"$\tau = {delay_s:g}$ s, $L = 5$, $P = 1/(e\tau)$"),
    ):
        scenario = load_scenario(f"paper-no-delay{ending}")
        scenario.name = f"paper-{name}{ending}"
        scenario.set("link.control.delay_s", delay, "the paper's delay")
        if gain is not None:
            scenario.set_parameter("INNER_P", gain, "the paper's optimum")
        flights.append(PaperFlight(scenario, label, title))
    return flights


def make_paper(folder: Path, plant: str, force: bool, progress: Callable[[str], None]) -> list[dict[str, Any]]:
    """Fly the three runs on `plant`, write figures and numbers.csv into `folder`, and return the table's rows.

    Raises:
        FileRefusedError: one of the files exists, and `force` is not set.
    """
    folder.mkdir(parents=True, exist_ok=True)
    flights = paper_flights(plant)
    for name in ("lambert-w", *(f"{kind}-{flight.label}" for flight in flights for kind in _FIGURES)):
        check_picture(folder / f"{name}.png", force)
    check_new_file(folder / "numbers.csv", force)
    figure, axes = new_figure(6.0, 4.5)
    draw_lambert_w(axes)
    save(figure, folder / "lambert-w.png")
    progress("lambert-w.png")
    rows = []
    for flight in flights:
        result = run_scenario(flight.scenario, RunOptions(), notice=progress)
        rows.append({column: result.numbers[column] for column in _COLUMNS})
        _draw(result, flight, folder)
        progress(f"trajectory-{flight.label}.png, turning-angle-{flight.label}.png")
    with (folder / "numbers.csv").open("w", newline="", encoding="ascii") as file:
        writer = csv.DictWriter(file, _COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    return rows


def _draw(result: RunResult, flight: PaperFlight, folder: Path) -> None:
    """The trajectory, and the turning angle of the first part."""
    track = result.flight.track()
    figure, axes = new_figure(6.0, 3.6)
    draw_trajectory(axes, track, result.flight.eight)
    figure.suptitle(flight.title, fontsize=11)
    save(figure, folder / f"trajectory-{flight.label}.png")
    shown = track.time_s < _ANGLE_WINDOW_S
    figure, axes = new_figure(6.0, 3.6)
    draw_turning_angle(axes, track.time_s[shown], track.course[shown], track.target_course[shown])
    figure.suptitle(flight.title, fontsize=11)
    save(figure, folder / f"turning-angle-{flight.label}.png")
