"""Flights as other teams log them: own names and units, slow sensors, gaps (data: see tests/data/flight/README.md)."""

import csv
import gzip
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from kite_analysis.flights.description import PUBLIC_FLIGHT, QUANTITIES, FlightDataError, load_description
from kite_analysis.flights.reader import read_record
from kite_analysis.identification.actuator_fit import identify_actuator
from kite_analysis.identification.turning_rate_fit import identify_law
from sim_bridge.cli.options.identify import EPILOG

FLIGHT = Path(__file__).parent.parent / "data" / "flight" / "20191008_0030.csv.gz"
OURS = """
title = "theirs"
smoothing_s = 1.1
smooth_both = false
[columns]
time = { column = "t", unit = "ms" }
elevation = { column = "el", unit = "deg" }
azimuth = { column = "az", unit = "deg" }
heading = { column = "psi", unit = "deg" }
airspeed = { column = "va", unit = "km/h" }
steering = { column = "u", factor = 0.005 }
distance = { column = "r", unit = "m", optional = true }
[phase]
column = "what"
values = ["eights", 7]
"""


@pytest.fixture(scope="module")
def rows() -> list[dict[str, str]]:
    with gzip.open(FLIGHT, "rt", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def write(path: Path, rows: list[dict[str, str]]) -> Path:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)
    return path


def changed(rows, **change) -> list[dict[str, str]]:
    """Copies of `rows` with columns replaced by what the functions of (index, value) give."""
    return [row | {name: function(index, row[name]) for name, function in change.items()}
            for index, row in enumerate(rows)]


def test_another_teams_file_gives_the_same_law(rows, tmp_path):
    """Other names, units, a phase in words, and heading the other way round, as the signs of ours are."""
    theirs = [{
        "t": f"{1000 * float(row['time']):.1f}", "el": np.degrees(float(row["kite_elevation"])),
        "az": -np.degrees(float(row["kite_azimuth"])), "psi": -np.degrees(float(row["kite_heading"])),
        "va": 3.6 * float(row["airspeed_apparent_windspeed"]), "u": 2 * float(row["kite_actual_steering"]),
        "what": "eights" if row["flight_phase_index"] == "1" else "pumping",
    } for row in rows]
    columns = tmp_path / "theirs.toml"
    columns.write_text(OURS)
    record = read_record(write(tmp_path / "theirs.csv", theirs), columns)
    assert record.title == "theirs" and not record.attribution and not record.has("course")
    assert identify_law(record)[3:] == pytest.approx(identify_law(read_record(FLIGHT))[3:], rel=1e-4)


def test_a_slow_airspeed_is_read_where_it_is_new_and_straight_between(rows, tmp_path):
    """1 Hz in a file of 10 Hz, with old values or nothing between: the same straight lines, and nearly the same K."""
    name = "airspeed_apparent_windspeed"
    held = changed(rows, **{name: lambda index, value: rows[index - index % 10][name]})
    empty = changed(rows, **{name: lambda index, value: "" if index % 10 else value})
    full = read_record(FLIGHT)
    records = [read_record(write(tmp_path / f"{number}.csv", each)) for number, each in enumerate((held, empty))]
    for record in records:
        at_readings = record.airspeed[:1390:10]
        assert at_readings == pytest.approx(full.airspeed[:1390:10], abs=1e-3)
        assert record.airspeed[5:1385:10] == pytest.approx(0.5 * (at_readings[:-1] + at_readings[1:]), abs=1e-3)
        assert identify_law(record).k_rad_per_m == pytest.approx(identify_law(full).k_rad_per_m, rel=0.02)


def test_short_gaps_are_bridged_and_long_ones_left_out(rows, tmp_path):
    """Across the wrap of the angle too; what lies around a gap of 3 s is used, nothing in it is made up."""
    broken = changed(rows, kite_heading=lambda index, value:
                     "" if 500 <= index < 530 or index % 50 in (7, 8) else value)
    full, record = read_record(FLIGHT), read_record(write(tmp_path / "broken.csv", broken))
    assert np.all(np.isnan(record.heading[500:530])) and np.all(np.isfinite(record.heading[600:]))
    assert np.all(np.isfinite(record.heading[530:]))
    assert np.max(np.abs(np.diff(record.heading[530:]))) < 0.3
    late = slice(530, None)
    assert record.heading[late] - full.heading[late] == pytest.approx(
        np.full(len(full.heading) - 530, record.heading[530] - full.heading[530]), abs=0.03)
    fit, whole = identify_law(record), identify_law(full)
    assert whole.seconds - 5.0 < fit.seconds < whole.seconds - 3.0
    assert fit.k_rad_per_m == pytest.approx(whole.k_rad_per_m, rel=0.01)


def test_rows_that_are_missing_are_a_gap(rows, tmp_path):
    record = read_record(write(tmp_path / "cut.csv", rows[:600] + rows[630:]))
    assert record.time_s[-1] == pytest.approx(read_record(FLIGHT).time_s[-1], abs=0.01)
    for name in ("heading", "elevation", "steering", "set_steering"):
        assert np.all(np.isnan(getattr(record, name)[607:628])), name
    assert identify_law(record).k_rad_per_m == pytest.approx(0.213, abs=0.005)


@pytest.mark.parametrize(("old", "new", "message"), [
    ('unit = "km/h"', 'unit = "deg"', r"columns.airspeed: unit \"deg\" is none of m/s, km/h, kn"),
    ('unit = "km/h"', 'unit = "km/h", factor = 2', "either unit or factor"),
    ('unit = "km/h"', "factor = 0", "must be finite and not 0"),
    ('unit = "km/h"', 'unit = "km/h", sgin = -1', "unknown key sgin"),
    ('unit = "km/h"', 'unit = "km/h", sign = 2', "must be 1 or -1"),
    ('unit = "km/h"', 'unit = "km/h", max_gap_s = -1', "must be 0 or longer"),
    ('unit = "km/h"', 'unit = "km/h", holds = "until_next_row"', "holds is for set_steering"),
    ("airspeed =", "speed =", "no such quantity; there are time, azimuth"),
    ('airspeed = { column = "va", unit = "km/h" }', "", "columns.airspeed is missing"),
    ('heading = { column = "psi", unit = "deg" }', "", "neither columns.heading nor columns.course"),
    ("smoothing_s = 1.1", "smoothing_s = -1", "between 0 and 60"),
    ("smoothing_s = 1.1", 'smoothing_s = "wide"', "smoothing_s must be a number"),
    ('values = ["eights", 7]', "", "phase: needs column"),
    ('values = ["eights", 7]', "values = [[1]]", "numbers or strings"),
    ("[phase]", "[phases]", "unknown key phases"),
    ("[columns]", "[columns", "not TOML"),
])
def test_a_wrong_description_is_answered_in_a_line(old, new, message, tmp_path):
    path = tmp_path / "wrong.toml"
    assert old in OURS
    path.write_text(OURS.replace(old, new))
    with pytest.raises(FlightDataError, match=message) as caught:
        load_description(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(("change", "message"), [
    ({"kite_heading": lambda index, value: "up" if index == 3 else value}, "line 5, column kite_heading: 'up'"),
    ({"flight_phase_index": lambda index, value: "4"}, "no row has flight_phase_index 1"),
    ({"time": lambda index, value: "3.0" if index == 9 else value}, "time goes back in line 11"),
    ({"time": lambda index, value: "" if index == 9 else value}, "line 11: no time"),
    ({"kite_elevation": lambda index, value: str(57.3 * float(value))}, "elevation of 36.* rad in half of the rows"),
    ({"kite_actual_steering": lambda index, value: str(100.0 * float(value))}, "steering of .* of the range in half"),
    ({"time": lambda index, value: str(1e9 * (index > 700) + 0.1 * index)}, "the time jumps"),
])
def test_a_wrong_file_is_answered_in_a_line(rows, change, message, tmp_path):
    with pytest.raises(FlightDataError, match=message):
        read_record(write(tmp_path / "wrong.csv", changed(rows, **change)))


SECONDS = 'time = { column = "s", unit = "s", fraction = "us", fraction_unit = "us" }'


def in_two_columns(rows, second="us", per_second=1_000_000) -> list[dict[str, str]]:
    """Whole seconds in one column, the rest of the time in another, in the public flight's names otherwise."""
    whole = [int(float(row["time"])) for row in rows]
    return [row | {"time": str(all_s), second: str(round(per_second * (float(row["time"]) - all_s)))}
            for row, all_s in zip(rows, whole, strict=True)]


def test_a_time_in_two_columns_gives_the_same_fit(rows, tmp_path):
    columns = tmp_path / "two.toml"
    columns.write_text(PUBLIC_FLIGHT.read_text("utf-8").replace(
        'time = { column = "time", unit = "s" }', SECONDS.replace('"s", unit', '"time", unit')))
    record = read_record(write(tmp_path / "two.csv", in_two_columns(rows)), columns)
    whole = read_record(FLIGHT)
    assert record.time_s == pytest.approx(whole.time_s, abs=1e-6)
    assert identify_law(record)[3:] == pytest.approx(identify_law(whole)[3:], rel=1e-6)
    assert identify_actuator(record).dead_time_s == pytest.approx(identify_actuator(whole).dead_time_s, abs=1e-4)


def test_a_time_without_its_fraction_is_refused_and_the_column_named(rows, tmp_path):
    """And so is what is left when repeated rows are dropped: its dead time would be 0.8 s where it is 0.48 s."""
    two = in_two_columns(rows, "millis", 1000)
    with pytest.raises(FlightDataError, match=r"still in line 3 and in 90% .*column millis looks like one") as caught:
        read_record(write(tmp_path / "whole.csv", two))
    assert 'fraction = "millis"' in str(caught.value) and "\n" not in str(caught.value)
    dropped = [row for before, row in pairwise(two) if row["time"] != before["time"]]
    with pytest.raises(FlightDataError, match=r"one row every 1 s is too few.*Were rows of equal time dropped"):
        identify_law(read_record(write(tmp_path / "dropped.csv", dropped)))
    with pytest.raises(FlightDataError, match="these rows are exact copies of the previous ones; drop them"):
        read_record(write(tmp_path / "twice.csv", [row for row in rows for _ in range(2)]))
    with pytest.raises(FlightDataError, match="line 12 has the time of the line before"):
        read_record(write(tmp_path / "slip.csv", [*rows[:10], rows[9] | {"kite_azimuth": "0"}, *rows[10:]]))


@pytest.mark.parametrize(("entry", "message"), [
    (SECONDS.replace('fraction_unit = "us"', 'fraction_unit = "deg"'), "fraction_unit, one of s, ms, us, ns"),
    (SECONDS.replace('fraction = "us", ', ""), "fraction is for time, and needs"),
    (SECONDS, "column s is missing .and 1 more.: .*two.toml names it; the file has time, date, "),
])
def test_a_wrong_fraction_is_answered_in_a_line(entry, message, tmp_path):
    columns = tmp_path / "two.toml"
    columns.write_text(PUBLIC_FLIGHT.read_text("utf-8").replace('time = { column = "time", unit = "s" }', entry))
    with pytest.raises(FlightDataError, match=message):
        read_record(FLIGHT, columns)


@pytest.mark.parametrize(("content", "message"), [
    (b"", "empty"), (b"\xff\xfe\x00", "not a CSV file"), (b"\0" * 99, "column time is missing"),
    (b"t;el;az\n1;2;3\n", "';' separates the columns"), (b'time\n"' + b"x" * 200_000, "not a CSV file"),
    (FLIGHT.read_bytes()[:20_000], "Compressed file ended"), (bytes(range(256)), "Not a gzipped file"),
])
def test_what_is_no_table_is_answered_in_a_line(content, message, tmp_path):
    path = tmp_path / ("flight.csv.gz" if "ompress" in message or "gzip" in message else "flight.csv")
    path.write_bytes(content)
    with pytest.raises(FlightDataError, match=message) as caught:
        read_record(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_the_documented_description_is_one(tmp_path):
    """docs/flight-files.md, and `identify --help`, as they are printed."""
    page = (Path(__file__).parents[2] / "docs" / "flight-files.md").read_text("utf-8")
    for number, text in enumerate((page.split("```toml\n")[1].split("```")[0], EPILOG.split("every key):\n")[1])):
        path = tmp_path / f"{number}.toml"
        path.write_text(text)
        description = load_description(path)
        assert description.phase_values == ("reel-out",) and {"time", "heading", "steering"} <= set(description.columns)
    assert set(QUANTITIES) <= set(page.replace("`", " ").replace(",", " ").split())
