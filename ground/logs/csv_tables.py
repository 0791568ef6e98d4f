"""A log as CSV: one table of the flight, or one for every kind of message. SI units and radians throughout."""

import csv
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from ground.link.connection import Address
from ground.logs.quantities import flight_table
from ground.logs.reader import FlightLog, Logged
from ground.vehicle.state import mode_name
from protocol import dialect

_EXACT = 9  # digits that tell one float32 from the next
_WHOLE = ("armed", "status", "valid", "tick_us", "tick_worst_us", "overruns", "samples_dropped")


def write_flight(log: FlightLog, vehicle: Address, path: Path) -> int:
    """Write a row for each state message to `path`; how many. A cell is empty where nothing was measured.

    Raises:
        OSError: the file cannot be written.
    """
    table = flight_table(log, vehicle)
    start_s = log.start_us * 1e-6
    columns = {"utc_s": [f"{start_s + time_s:.6f}" for time_s in table["time_s"]]}
    for name, values in table.items():
        if name == "mode":
            columns[name] = [mode_name(int(value)) for value in values]
        elif name.endswith("time_s"):
            columns[name] = [f"{value:.6f}" for value in values]
        else:
            columns[name] = [_cell(value, name in _WHOLE) for value in values]
    _write(path, list(columns), zip(*columns.values(), strict=True))
    return len(table["time_s"])


def write_messages(log: FlightLog, folder: Path) -> int:
    """Write a file for each kind of message into `folder`, with all its fields, whoever sent it; how many files.

    Raises:
        OSError: a file cannot be written.
    """
    kinds: dict[str, list[Logged]] = {}
    for entry in log.messages:
        if not isinstance(entry.message, dialect.MAVLink_unknown):
            kinds.setdefault(entry.message.get_type(), []).append(entry)
    folder.mkdir(parents=True, exist_ok=True)
    for name, entries in kinds.items():
        kind = type(entries[0].message)
        heads = ["time_s", "utc_us", "system", "component", "sequence"]
        for field in kind.fieldnames:
            count = _array_length(kind, field)
            heads += [f"{field}_{index}" for index in range(count)] if count else [field]
        rows = ([f"{entry.time_s:.6f}", log.start_us + round(entry.time_s * 1e6), *entry.sender, entry.sequence,
                 *_values(entry, kind)] for entry in entries)
        _write(folder / f"{name.lower()}.csv", heads, rows)
    return len(kinds)


def _write(path: Path, heads: list[str], rows: Iterable[Sequence[Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(heads)
        writer.writerows(rows)


def _array_length(kind: type[dialect.MAVLink_message], field: str) -> int:
    """How many cells a field takes, or 0 for one of its own; a text is one."""
    at = kind.ordered_fieldnames.index(field)
    return 0 if kind.fieldtypes[kind.fieldnames.index(field)] == "char" else kind.array_lengths[at]


def _values(entry: Logged, kind: type[dialect.MAVLink_message]) -> list[Any]:
    cells = []
    for field, kind_of_field in zip(kind.fieldnames, kind.fieldtypes, strict=True):
        value = getattr(entry.message, field)
        for one in value if isinstance(value, list | tuple) else [value]:
            cells.append(_cell(one, False) if kind_of_field == "float" else one)
    return cells


def _cell(value: float, whole: bool) -> str:
    if math.isnan(value):
        return ""
    return str(int(value)) if whole else f"{value:.{_EXACT}g}"
