"""A CSV file of a flight, gzipped or not, as columns in the project's units and signs."""

import csv
import gzip
import zlib
from pathlib import Path

import numpy as np

from kite_analysis.figure_eight import Array
from kite_analysis.flights.checks import Row, check_times, check_units
from kite_analysis.flights.description import Column, ColumnDescription, FlightDataError
from kite_analysis.flights.record import FlightRecord, as_recorded

_NO_VALUE = 1e6  # what a logger writes in place of a value it does not know may be as large as this, or infinite
_MANY = 12  # columns; more of them are not listed


def read_table(path: Path, description: ColumnDescription, whole_lines: bool = False) -> FlightRecord:
    """The flight as recorded, by the columns that `description` names: time from the first row on.

    With `whole_lines` a last line that was cut off is left out.

    Raises:
        FlightDataError: no such file, not a CSV, columns missing, a value that is no number, no rows, times that do
            not grow or jump too far, values that cannot be in the unit they are said to be in.
    """
    try:
        opener = gzip.open if path.suffix == ".gz" else open
        with opener(path, "rt", newline="", encoding="utf-8-sig") as file:
            lines = list(csv.reader(line for line in file if line.endswith("\n") or not whole_lines))
    except (OSError, EOFError, UnicodeDecodeError, csv.Error, zlib.error) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else f"not a CSV file: {error}"
        raise FlightDataError(f"{path}: {reason}") from error
    names, *others = lines or [[]]
    rows = [Row(line, fields) for line, fields in enumerate(others, start=2) if fields]
    if not names:
        raise FlightDataError(f"{path}: empty")
    if len(names) == 1 and (other := next((mark for mark in ";\t|" if mark in names[0]), "")):
        raise FlightDataError(f"{path}: {other!r} separates the columns; use commas")
    _check_names(names, description, path)
    if len(rows) < 2:
        raise FlightDataError(f"{path}: {'one row' if rows else 'no rows'}; a flight needs at least two")
    time_s = _times(names, rows, description.columns["time"], path)
    values = _values(names, rows, description, path)
    check_times(time_s, names, rows, description.columns["time"], path)
    check_units(values, path)
    return as_recorded(time_s - time_s[0], values, description.title, description.attribution, description.smoothing_s,
                       description.smooth_both, _selected(names, rows, description))


def _check_names(names: list[str], description: ColumnDescription, path: Path) -> None:
    """Raises FlightDataError where a column is not there that must be, and says what would help."""
    columns = description.columns
    wanted = [column.column for column in columns.values() if not column.optional]
    wanted += [name for name in (description.phase_column, columns["time"].fraction) if name]
    missing = [name for name in wanted if name not in names]
    if not missing:
        return
    text = f"{path}: column {missing[0]} is missing" + (f" (and {len(missing) - 1} more)" if len(missing) > 1 else "")
    if description.own:
        has = ", ".join(names[:_MANY]) + (", ..." if len(names) > _MANY else "")
        raise FlightDataError(f"{text}: {description.path} names it; the file has {has}")
    raise FlightDataError(f"{text} of those of \"{description.title}\"; if this file is another kind of flight, say "
                          "what its columns mean with --columns FILE.toml (docs/flight-files.md has the format)")


def _values(names: list[str], rows: list[Row], description: ColumnDescription, path: Path) -> dict[str, Array]:
    """The quantities that the file has, (n,) each; NaN where a field is empty."""
    values: dict[str, Array] = {}
    for quantity, column in description.columns.items():
        if quantity != "time" and column.column in names:
            read = _numbers(names, rows, column.column, path) * column.factor
            values[quantity] = np.where(np.abs(read) < _NO_VALUE, read, np.nan)
    return values


def _selected(names: list[str], rows: list[Row], description: ColumnDescription) -> Array:
    """True in the rows (n,) of the described phase."""
    phase = names.index(description.phase_column) if description.phase_column else -1
    return np.array([phase < 0 or (phase < len(row.fields) and _is_one_of(row.fields[phase], description))
                     for row in rows], dtype=bool)


def _times(names: list[str], rows: list[Row], column: Column, path: Path) -> Array:
    """Times [s] since the first row; whole seconds and fractions are added up before precision is lost."""
    whole = _numbers(names, rows, column.column, path)
    time_s = (whole - whole[0]) * column.factor
    if column.fraction:
        time_s = time_s + _numbers(names, rows, column.fraction, path) * column.fraction_factor
    return time_s


def _numbers(names: list[str], rows: list[Row], name: str, path: Path) -> Array:
    index = names.index(name)
    return np.array([_number(fields[index] if index < len(fields) else "", path, line, name)
                     for line, fields in rows])


def _number(text: str, path: Path, line: int, column: str) -> float:
    """A field's value; NaN if it is empty."""
    try:
        return float(text) if text and not text.isspace() else np.nan
    except ValueError:
        raise FlightDataError(f"{path}: line {line}, column {column}: {text[:40]!r} is not a number") from None


def _is_one_of(text: str, description: ColumnDescription) -> bool:
    """Is this one of the phase's values, as a text or as a number?"""
    for value in description.phase_values:
        if isinstance(value, str):
            if text == value:
                return True
        else:
            try:
                if float(text or "nan") == float(value):
                    return True
            except ValueError:
                continue
    return False
