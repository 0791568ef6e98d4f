"""Recorded flights of a real kite, converted to the project's frames and signs.

The data: Schelbergen, Schmehl, Buchholz, Breuer and Peschel (TU Delft and Kitepower B.V., thekitepower.com), flight
of 8 October 2019, CC-BY 4.0, github.com/awegroup/Flightdata08102019. Its columns are described in
`descriptions/v3_20191008.toml` only.
"""

from pathlib import Path

import numpy as np

from kite_analysis.console.optional_packages import ExtraMissingError
from kite_analysis.figure_eight import Array, TargetEight, unit_position
from kite_analysis.flights.checks import check_period
from kite_analysis.flights.description import (
    PUBLIC_FLIGHT,
    ColumnDescription,
    FlightDataError,
    load_description,
    no_phase,
)
from kite_analysis.flights.record import FlightRecord
from kite_analysis.flights.table import read_table

_LEAST_S = 5.0  # of flight; with less there is no eight
_LEAST_AZIMUTH = 0.02  # [rad], from side to side


def read_flight(path: Path, columns: Path | None = None) -> FlightRecord:
    """Read a flight row by row, CSV or gzipped CSV; NaN where a field is empty, or the file has no such column.

    `columns` describes the columns (default: those of the public flight).

    Raises:
        FlightDataError: it cannot be read, or has no azimuth or course, or no rows in the described phase.
    """
    description = load_description(columns or PUBLIC_FLIGHT)
    flight = read_table(path, description)
    try:
        _check_usable(flight, description)
    except FlightDataError as error:
        raise FlightDataError(f"{path}: {error}") from error
    return flight


def _check_usable(flight: FlightRecord, description: ColumnDescription) -> None:
    """Raises FlightDataError where there is too little to use."""
    if not flight.selected.any():
        raise FlightDataError(no_phase(description))
    check_period(flight.period_s)
    for quantity in ("azimuth", "elevation", "course"):
        known_s = np.count_nonzero(np.isfinite(getattr(flight, quantity)[flight.selected])) * flight.period_s
        if known_s < _LEAST_S:
            raise FlightDataError(f"{quantity} is known for {known_s:.1f} s of the part that is used; "
                                  f"at least {_LEAST_S:g} s are needed")
    azimuth = flight.azimuth[flight.selected]
    if np.ptp(azimuth[np.isfinite(azimuth)]) < _LEAST_AZIMUTH:
        raise FlightDataError("the azimuth hardly changes in the part that is used: no eights flown")


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
        _, distance = _eight(unknowns, 1.0).nearest(position)
        return distance

    guess = [np.mean(azimuth), np.mean(elevation), np.sqrt(2) * np.std(azimuth), np.sqrt(2) * np.std(swing)]
    eight = _eight(least_squares(distances, guess, loss="soft_l1", f_scale=0.01).x, 1.0)
    sine = np.clip((azimuth - eight.azimuth) / eight.half_width, -1.0, 1.0)
    cosine = np.sqrt(1.0 - sine**2) * np.sign(np.gradient(azimuth))
    return eight._replace(direction=1.0 if np.sum(swing * sine * cosine) >= 0.0 else -1.0)


def _eight(unknowns: Array, direction: float) -> TargetEight:
    azimuth, elevation, half_width, half_height = (float(value) for value in unknowns)
    return TargetEight(azimuth, elevation, half_width, half_height, direction)
