"""Real flights with the firmware as their shadow (data: see tests/data/flight/README.md)."""

import csv
import gzip
import json
from pathlib import Path

import numpy as np
import pytest

from kite_analysis.angles import wrap
from kite_analysis.figure_eight import TargetEight, turning_angle, unit_position
from kite_analysis.flights.real_flight import fit_eight, read_flight
from sim_bridge.cli.main import main
from sim_bridge.studies.shadow_flight import fly_shadow

FLIGHTS = sorted((Path(__file__).parent.parent / "data" / "flight").glob("*.csv.gz"))


def test_there_are_three_flights():
    assert len(FLIGHTS) == 3


@pytest.mark.parametrize("path", FLIGHTS, ids=lambda path: path.name[9:13])
def test_the_firmware_finds_the_recorded_course_from_positions_alone(path):
    flight = fly_shadow(path, "cpython", print)
    assert flight.numbers["turning_angle_rms_deg"] < 7.0
    assert abs(flight.numbers["turning_angle_bias_deg"]) < 1.0
    flown = flight.tracking & flight.data.selected
    assert flown.sum() > 0.9 * flight.data.selected.sum()
    assert np.corrcoef(flight.steering_asked[flown], flight.data.steering[flown])[0, 1] > 0.3


@pytest.mark.parametrize("path", FLIGHTS, ids=lambda path: path.name[9:13])
def test_the_recorded_course_is_the_direction_of_the_recorded_positions(path):
    """The signs of the file: a wrong one would put the course on the other side."""
    data = read_flight(path)
    position = unit_position(data.azimuth, data.elevation)
    course = turning_angle(position[2:-2], position[4:] - position[:-4])
    error = wrap(course - data.course[2:-2])[data.selected[2:-2]]
    assert np.degrees(np.sqrt(np.mean(error**2))) < 5.0


def test_another_teams_flight_has_a_shadow(tmp_path, capsys):
    """Its own names and units, and neither distance nor force: the same turning angle as by the public names."""
    rows = []
    with gzip.open(FLIGHTS[0], "rt", newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            rows.append({"t": 1000.0 * float(row["time"]), "el": np.degrees(float(row["kite_elevation"])),
                         "az": row["kite_azimuth"], "chi": row["kite_course"], "u": row["kite_actual_steering"],
                         "va": row["airspeed_apparent_windspeed"],
                         "what": "eights" if row["flight_phase_index"] == "1" else "reel-in"})
    with (tmp_path / "theirs.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)
    (tmp_path / "theirs.toml").write_text("""
        [columns]
        time = { column = "t", unit = "ms" }
        elevation = { column = "el", unit = "deg" }
        azimuth = { column = "az", unit = "rad", sign = -1 }
        course = { column = "chi", unit = "rad", sign = -1 }
        airspeed = { column = "va", unit = "m/s" }
        steering = { column = "u", unit = "%" }
        [phase]
        column = "what"
        values = ["eights"]""")
    theirs = [str(tmp_path / "theirs.csv"), "--columns", str(tmp_path / "theirs.toml")]
    plot = str(tmp_path / "plot.png")
    assert main(["shadow", *theirs, "--runtime", "inproc", "--json", "--plot", plot]) == 0
    numbers = json.loads(capsys.readouterr().out)
    ours = fly_shadow(FLIGHTS[0], "inproc", print).numbers
    assert numbers["turning_angle_rms_deg"] == pytest.approx(ours["turning_angle_rms_deg"], abs=0.5)
    assert numbers["reel_out_s"] == pytest.approx(ours["reel_out_s"], abs=1.0)
    assert main(["shadow", theirs[0]]) == 2
    assert "column time is missing (and 10 more)" in (said := capsys.readouterr().err) and "--columns FILE" in said


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_the_fit_finds_the_eight_that_was_flown(direction):
    eight = TargetEight(0.05, 0.6, 0.35, 0.08, direction)
    s = direction * np.linspace(0.0, 30.0, 900)
    azimuth, elevation = eight.angles(s)
    noise = np.random.default_rng(1).normal(0.0, 0.003, (2, len(s)))
    fitted = fit_eight(azimuth + noise[0], elevation + noise[1] + np.linspace(-0.03, 0.03, len(s)))
    assert fitted == pytest.approx(eight, abs=0.01)
