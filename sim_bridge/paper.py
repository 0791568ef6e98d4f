"""The paper's seven figures and a table of their numbers, from flights of this project.

J. H. Baayen, "Trajectory tracking control of kites with system delay" (2012), section 5.
"""

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

from analysis.plots import draw_lambert_w, draw_trajectory, draw_turning_angle, new_figure, save
from sim_bridge.run import RunOptions, run_scenario
from sim_bridge.scenario import load_scenario

# Scenario, and the name that the paper's own figures have.
_FLIGHTS = (
    ("paper-no-delay", "D0L5P10", r"$\tau = 0$ s, $L = 5$, $P = 10$"),
    ("paper-delay", "D200L5P10", r"$\tau = 0.2$ s, $L = 5$, $P = 10$"),
    ("paper-delay-tuned", "D200L5Popt", r"$\tau = 0.2$ s, $L = 5$, $P = 1/(e\tau)$"),
)
_COLUMNS = ("scenario", "verdict", "cross_track_rms_rad", "cross_track_max_rad", "turning_angle_rms_rad",
            "steering_rms", "saturated_fraction")
_ANGLE_WINDOW_S = 40.0


def make_paper(folder: Path, progress: Callable[[str], None]) -> list[dict[str, Any]]:
    """Fly the three runs, write figures and numbers.csv into `folder`, and return the table's rows."""
    folder.mkdir(parents=True, exist_ok=True)
    figure, axes = new_figure(6.0, 4.5)
    draw_lambert_w(axes)
    save(figure, folder / "lambert-w.png")
    progress("lambert-w.png")
    rows = []
    for name, label, title in _FLIGHTS:
        result = run_scenario(load_scenario(name), RunOptions())
        rows.append({column: result.numbers[column] for column in _COLUMNS})
        track = result.flight.track()
        figure, axes = new_figure(6.0, 3.6)
        draw_trajectory(axes, track, result.flight.eight)
        axes.set_title(title)
        save(figure, folder / f"trajectory-{label}.png")
        shown = track.time_s < _ANGLE_WINDOW_S
        figure, axes = new_figure(6.0, 3.6)
        draw_turning_angle(axes, track.time_s[shown], track.course[shown], track.target_course[shown])
        axes.set_title(title)
        save(figure, folder / f"turning-angle-{label}.png")
        progress(f"trajectory-{label}.png, turning-angle-{label}.png")
    with (folder / "numbers.csv").open("w", newline="", encoding="ascii") as file:
        writer = csv.DictWriter(file, _COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    return rows
