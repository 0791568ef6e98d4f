"""A CSV file of a flight, gzipped or not, as columns in our units and signs."""

import csv
import gzip
from pathlib import Path
from typing import NamedTuple

import numpy as np

from analysis.column_description import ColumnDescription, FlightDataError
from analysis.target_eight import Array


class FlightTable(NamedTuple):
    """Rows as recorded, (n,) each: time from the first row on, NaN where a field is empty."""

    time_s: Array
    values: dict[str, Array]  # the quantities that the file has
    selected: Array  # True in the described phase


def read_table(path: Path, description: ColumnDescription, whole_lines: bool = False) -> FlightTable:
    """Read the columns that `description` names; with `whole_lines` a last line that was cut off is left out.

    Raises:
        FlightDataError: no such file, not a CSV, columns missing, a value that is no number, no rows.
    """
    try:
        opener = gzip.open if path.suffix == ".gz" else open
        with opener(path, "rt", newline="", encoding="utf-8") as file:
            lines = (line for line in file if line.endswith("\n") or not whole_lines)
            table = _read(csv.DictReader(lines), description, path)
    except (OSError, EOFError, UnicodeDecodeError, csv.Error) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise FlightDataError(f"{path}: {reason}") from error
    if len(table.time_s) < 2:
        raise FlightDataError(f"{path}: no rows")
    if not np.all(np.diff(table.time_s) > 0):
        row = int(np.argmin(np.diff(table.time_s) > 0))
        raise FlightDataError(f"{path}: time does not grow from row to row (line {row + 3})")
    return table._replace(time_s=table.time_s - table.time_s[0])


def _read(reader: csv.DictReader, description: ColumnDescription, path: Path) -> FlightTable:
    names = reader.fieldnames or []
    used = {quantity: column for quantity, column in description.columns.items() if column.column in names}
    wanted = [column.column for column in description.columns.values() if not column.optional]
    wanted += [description.phase_column] if description.phase_column else []
    missing = [name for name in wanted if name not in names]
    if missing:
        raise FlightDataError(f"{path}: column {missing[0]} is missing"
                              + (f" (and {len(missing) - 1} more)" if len(missing) > 1 else ""))
    rows: list[list[float]] = []
    selected: list[bool] = []
    for line, row in enumerate(reader, start=2):
        rows.append([_number(row[column.column], path, line, column.column) for column in used.values()])
        selected.append(not description.phase_column or _is_one_of(row[description.phase_column], description))
    columns = np.array(rows, dtype=float).reshape(len(rows), len(used)).T
    values = {quantity: column * used[quantity].factor for quantity, column in zip(used, columns, strict=True)}
    return FlightTable(values.pop("time"), values, np.array(selected, dtype=bool))


def _number(text: str | None, path: Path, line: int, column: str) -> float:
    """A field's value; NaN if it is empty."""
    try:
        return float(text) if text and not text.isspace() else np.nan
    except ValueError:
        raise FlightDataError(f"{path}: line {line}, column {column}: {text!r} is not a number") from None


def _is_one_of(text: str | None, description: ColumnDescription) -> bool:
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
