"""Checks of a flight's table before anything is fitted to it: increasing times, plausible units."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from kite_analysis.figure_eight import Array
from kite_analysis.flights.description import Column, FlightDataError

_LARGEST_GRID = 100  # rows of a uniform grid for each row recorded
_LOOKED_AT = 2000  # rows, for the column that holds a time's fraction
_COARSE = 0.2  # share of rows whose time stands still, from which on it is the clock and not a slip
_LONGEST_PERIOD_S = 0.5  # of rows: from there on turns are flattened, and lags come out longer by half of it
# Half of a flight's values lie below this, whatever the kite.
_MOST = {"elevation": (1.6, "rad"), "azimuth": (6.3, "rad"), "steering": (2.0, "of the range"),
         "set_steering": (2.0, "of the range"), "airspeed": (150.0, "m/s")}


class Row(NamedTuple):
    """A row of a file: its line, counted from 1, and its fields."""

    line: int
    fields: list[str]


def check_times(time_s: Array, names: list[str], rows: list[Row], column: Column, path: Path) -> None:
    """Raises FlightDataError if times [s] (n,) of `rows` are missing, do not increase, or jump far."""
    unknown = np.flatnonzero(~np.isfinite(time_s))
    if len(unknown):
        raise FlightDataError(f"{path}: line {rows[int(unknown[0])].line}: no time")
    steps = np.diff(time_s)
    if np.any(steps < 0.0):
        raise FlightDataError(f"{path}: time goes back in line {rows[int(np.argmax(steps < 0.0)) + 1].line}")
    if np.any(steps == 0.0):
        line, share = rows[int(np.argmax(steps == 0.0)) + 1].line, float(np.mean(steps == 0.0))
        if share < _COARSE:
            raise FlightDataError(f"{path}: line {line} has the time of the line before; keep only one")
        raise FlightDataError(f"{path}: time stands still in line {line} and in {share:.0%} of the rows: "
                              + _remedy(time_s, names, rows, column))
    check_span(time_s, str(path))


def check_span(time_s: Array, where: str) -> None:
    """Raises FlightDataError if a uniform grid over the increasing times [s] (n,) would be almost empty."""
    usual_s, span_s = float(np.median(np.diff(time_s))), float(time_s[-1] - time_s[0])
    if span_s > _LARGEST_GRID * len(time_s) * usual_s:
        raise FlightDataError(f"{where}: {len(time_s)} rows about {usual_s:g} s apart cannot span {span_s:g} s: "
                              "the time jumps, or has the wrong unit")


def check_period(period_s: float) -> None:
    """Raises FlightDataError if rows every `period_s` [s] are too few for a kite's turns."""
    if period_s > 1.001 * _LONGEST_PERIOD_S:
        raise FlightDataError(
            f"one row every {period_s:.3g} s is too few: turns need one every {_LONGEST_PERIOD_S:g} s or more often, "
            "better every 0.1 s. Is the unit of the time right? Were rows of equal time dropped? Keep them, and name "
            "the column with the fraction of the second (docs/flight-files.md)")


def check_units(values: dict[str, Array], path: Path) -> None:
    """Raises FlightDataError if half of a quantity's values, in SI units and radians, are implausible."""
    for quantity, (most, unit) in _MOST.items():
        known = np.abs(values.get(quantity, np.zeros(0)))
        known = known[np.isfinite(known)]
        if len(known) and np.median(known) > most:
            raise FlightDataError(f"{path}: {quantity} of {np.median(known):.3g} {unit} in half of the rows cannot be: "
                                  "is its unit in the columns' description right?")


def _remedy(time_s: Array, names: list[str], rows: list[Row], column: Column) -> str:
    """What to do about times that are repeated."""
    again = np.flatnonzero(np.diff(time_s) == 0.0)
    if all(rows[k].fields == rows[k + 1].fields for k in again):
        return "these rows are exact copies of the previous ones; drop them"
    name = _fraction_column(time_s, names, rows)
    looks = f"column {name} looks like one" if name else "no column looks like one"
    return (f"is the fraction of a second in another column ({looks})? Then say in the file for --columns: time = "
            f"{{ column = \"{column.column}\", unit = ..., fraction = \"{name or '...'}\", fraction_unit = \"ms\" }}; "
            "do not drop rows, that corrupts the fit")


def _fraction_column(time_s: Array, names: list[str], rows: list[Row]) -> str | None:
    """The column that grows wherever the time stands still, and falls back where it goes on."""
    stands = np.diff(time_s[:_LOOKED_AT]) == 0.0
    for index, name in enumerate(names):
        try:
            values = np.array([float(fields[index]) for _, fields in rows[:_LOOKED_AT]])
        except (ValueError, IndexError):
            continue
        steps = np.diff(values)
        if np.all(steps[stands] > 0.0) and np.any(steps[~stands] < 0.0) and np.all(values >= 0.0):
            return name
    return None
