"""Reads a flight for identification from a run log, a tlog or a CSV file."""

from pathlib import Path

from kite_analysis.flights.description import (
    PUBLIC_FLIGHT,
    SIMULATED_RUN,
    ColumnDescription,
    FlightDataError,
    load_description,
)
from kite_analysis.flights.record import FlightRecord, evenly_spaced
from kite_analysis.flights.table import read_table
from kite_analysis.flights.telemetry import read_tlog_record

_TRUTH = "truth.csv"


def read_record(source: Path, columns: Path | None = None) -> FlightRecord:
    """The flight in `source`: a run log's folder or its truth.csv, a .tlog, or a CSV file, gzipped or not.

    `columns` describes the columns of a CSV file (default: those of the public flight).

    Raises:
        FlightDataError: it cannot be read as a flight.
    """
    if source.is_dir():
        source /= _TRUTH
        if not source.exists():
            raise FlightDataError(f"{source.parent}: a folder without {_TRUTH} is not a run log")
    if source.suffix == ".tlog":
        if columns:
            raise FlightDataError(f"{source}: a tlog has no columns to describe")
        return read_tlog_record(source)
    is_truth = source.name == _TRUTH  # of a run that may have been killed in the middle of a line
    description = description_of(source, columns)
    return evenly_spaced(read_table(source, description, whole_lines=is_truth), description, str(source))


def description_of(source: Path, columns: Path | None) -> ColumnDescription:
    """What the columns of the CSV file `source` mean: as `columns` says, or as its kind has them."""
    return load_description(columns or (SIMULATED_RUN if source.name == _TRUTH else PUBLIC_FLIGHT))
