"""A log as CSV: one table of the flight, or one for each message type. SI units and radians throughout."""

import csv
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from ground.logs.quantities import recorded_flight
from ground.logs.reader import Logged, MessageLog
from kite_analysis.angles import wrap
from protocol import dialect
from protocol.frame import Address
from protocol.modes import mode_name

_EXACT = 9  # digits that identify a float32
_QUANTITIES = {  # column: quantity of the flight
    "azimuth_rad": "azimuth", "elevation_rad": "elevation", "distance_m": "distance", "course_rad": "course",
    "target_course_rad": "target_course", "heading_rad": "heading", "cross_track_rad": "cross_track",
    "path_parameter_rad": "path_parameter", "steering_asked": "set_steering", "steering": "steering",
    "airspeed_m_s": "airspeed", "tether_force_n": "tether_force",
}
_COUNTED = ("status", "valid", "tick_us", "tick_worst_us", "late_worst_us", "overruns", "samples_dropped")


def write_flight(log: MessageLog, vehicle: Address, path: Path) -> int:
    """Write a row for each state message to `path`; return their number. A cell is empty if nothing was measured.

    Raises:
        OSError: the file cannot be written.
    """
    flight = recorded_flight(log, vehicle)
    start_s = log.start_us * 1e-6
    columns = {"utc_s": [f"{start_s + time_s:.6f}" for time_s in flight.time_s]}
    columns |= {name: [f"{value:.6f}" for value in values] for name, values in (
        ("time_s", flight.time_s), ("received_s", flight.further["received_s"]),
        ("vehicle_time_s", flight.further["vehicle_time_s"]))}
    columns["mode"] = [mode_name(int(value)) for value in flight.mode]
    columns["armed"] = [_cell(value, True) for value in flight.further["armed"]]
    columns |= {name: [_cell(value, False) for value in getattr(flight, quantity)]
                for name, quantity in _QUANTITIES.items()}
    columns["course_error_rad"] = [_cell(value, False) for value in wrap(flight.target_course - flight.course)]
    columns |= {name: [_cell(value, True) for value in flight.further[name]] for name in _COUNTED}
    _write(path, list(columns), zip(*columns.values(), strict=True))
    return len(flight.time_s)


def write_messages(log: MessageLog, folder: Path) -> int:
    """Write a file for each message type into `folder`, with all fields, from all senders; return their number.

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
        rows = ([f"{entry.time_s:.6f}", log.start_us + round(entry.time_s * 1e6), *entry.sender, entry.header.sequence,
                 *_values(entry, kind)] for entry in entries)
        _write(folder / f"{name.lower()}.csv", heads, rows)
    return len(kinds)


def _write(path: Path, heads: list[str], rows: Iterable[Sequence[Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(heads)
        writer.writerows(rows)


def _array_length(kind: type[dialect.MAVLink_message], field: str) -> int:
    """The number of elements of an array field, or 0 for a single value; a text is one."""
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
