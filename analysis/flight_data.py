"""Recorded flights of a real kite, read into the frames and signs that everything here uses.

The data: Schelbergen, Schmehl, Buchholz, Breuer and Peschel (TU Delft and Kitepower B.V., thekitepower.com), flight
of 8 October 2019, CC-BY 4.0, github.com/awegroup/Flightdata08102019. It measures azimuth, course and heading the
other way round; their signs change here and nowhere else.
"""

import csv
import gzip
from pathlib import Path
from typing import NamedTuple

import numpy as np

from analysis.extras import ExtraMissingError
from analysis.target_eight import Array, TargetEight, unit_position

ATTRIBUTION = (
    "Flight data: Schelbergen, Schmehl, Buchholz, Breuer, Peschel (TU Delft, Kitepower B.V.), CC-BY 4.0, "
    "github.com/awegroup/Flightdata08102019")
_REEL_OUT = 1
_NEWTON_PER_KG = 9.80665
# Field: column, and the factor into SI units and our signs.
_COLUMNS = {
    "time_s": ("time", 1.0),
    "azimuth": ("kite_azimuth", -1.0),
    "elevation": ("kite_elevation", 1.0),
    "distance": ("kite_distance", 1.0),
    "course": ("kite_course", -1.0),
    "heading": ("kite_heading", -1.0),
    "set_steering": ("kite_set_steering", 0.01),
    "steering": ("kite_actual_steering", 0.01),
    "airspeed": ("airspeed_apparent_windspeed", 1.0),
    "tether_force": ("ground_tether_force", _NEWTON_PER_KG),
    "phase": ("flight_phase_index", 1.0),
}


class FlightDataError(Exception):
    """A file cannot be read as a flight; the text says what is wrong and where, in one line."""


class FlightData(NamedTuple):
    """A recorded flight, each array (n,): SI units, radians, the project's signs; `time_s` starts at 0."""

    time_s: Array
    azimuth: Array
    elevation: Array
    distance: Array
    course: Array
    heading: Array
    set_steering: Array
    steering: Array
    airspeed: Array
    tether_force: Array
    phase: Array

    @property
    def reel_out(self) -> Array:
        """True where the kite flies eights."""
        return self.phase == _REEL_OUT


def read_flight(path: Path) -> FlightData:
    """Read a CSV file, gzipped or not.

    Raises:
        FlightDataError: no such file, not a CSV, columns missing, a value that is no number, no rows.
    """
    try:
        opener = gzip.open if path.suffix == ".gz" else open
        with opener(path, "rt", newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file)
            missing = [column for column, _ in _COLUMNS.values() if column not in (reader.fieldnames or [])]
            if missing:
                raise FlightDataError(f"{path}: column {missing[0]} is missing (and {len(missing) - 1} more)"
                                      if len(missing) > 1 else f"{path}: column {missing[0]} is missing")
            columns = _numbers(reader, path)
    except (OSError, EOFError, UnicodeDecodeError, csv.Error) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise FlightDataError(f"{path}: {reason}") from error
    data = FlightData(**{field: columns[column] * factor for field, (column, factor) in _COLUMNS.items()})
    if len(data.time_s) < 2:
        raise FlightDataError(f"{path}: no rows")
    if not np.all(np.diff(data.time_s) > 0):
        raise FlightDataError(f"{path}: time does not grow from row to row")
    return data._replace(time_s=data.time_s - data.time_s[0])


def _numbers(reader: csv.DictReader, path: Path) -> dict[str, Array]:
    """The columns that are used; an empty field becomes NaN."""
    columns: dict[str, list[float]] = {column: [] for column, _ in _COLUMNS.values()}
    for line, row in enumerate(reader, start=2):
        for column, values in columns.items():
            text = row[column]
            try:
                values.append(float(text) if text else np.nan)
            except ValueError:
                raise FlightDataError(f"{path}: line {line}, column {column}: {text!r} is not a number") from None
    return {column: np.array(values) for column, values in columns.items()}


def fit_eight(azimuth: Array, elevation: Array) -> TargetEight:
    """The eight nearest to a stretch of flight of several eights: azimuth and elevation [rad], each (n,).

    Centre, half-width and half-height by least squares of the distance to the curve, robust against the dive into
    the first eight; the elevation is taken about its own straight trend, since the kite climbs as the line is let
    out. The direction is the sign of the part of the elevation that goes with sin 2s, s from the azimuth and the
    sense in which it changes: +1 for a flight upwards through the middle.

    Raises:
        ExtraMissingError: scipy is not installed.
    """
    try:
        from scipy.optimize import least_squares  # noqa: PLC0415  an extra, and slow to load
    except ImportError:
        raise ExtraMissingError("fitting an eight needs scipy: pip install 'kitepilot[analysis]'") from None
    row = np.arange(len(elevation))
    slope, level = np.polyfit(row, elevation, 1)
    swing = elevation - slope * row - level
    position = unit_position(azimuth, np.mean(elevation) + swing)

    def distances(unknowns: Array) -> Array:
        return _eight(unknowns, 1.0).nearest(position)[1]

    guess = [np.mean(azimuth), np.mean(elevation), np.sqrt(2) * np.std(azimuth), np.sqrt(2) * np.std(swing)]
    found = least_squares(distances, guess, loss="soft_l1", f_scale=0.01).x
    sine = np.clip((azimuth - found[0]) / found[2], -1.0, 1.0)
    cosine = np.sqrt(1.0 - sine**2) * np.sign(np.gradient(azimuth))
    direction = 1.0 if np.sum(swing * sine * cosine) >= 0.0 else -1.0
    return _eight(found, direction)


def _eight(unknowns: Array, direction: float) -> TargetEight:
    azimuth, elevation, half_width, half_height = (float(value) for value in unknowns)
    return TargetEight(azimuth, elevation, half_width, half_height, direction)
