"""A flight on a uniform time grid, from any source: the input of identification."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from kite_analysis.flights.columns import QUANTITIES, ColumnDescription, FlightDataError, no_phase
from kite_analysis.flights.checks import check_span
from kite_analysis.flights.table import FlightTable
from kite_analysis.figure_eight import Array

_ANGLES = ("azimuth", "course", "heading")  # these wrap
_COMMANDS = ("steering", "set_steering")
_LEAST_UPDATES = 20  # fewer changes than this do not show how often a sensor is read


class Series(NamedTuple):
    """A quantity as recorded: times [s] (m,), growing, values (m,) with NaN where missing, the longest gap [s]."""

    time_s: Array
    values: Array
    max_gap_s: float


class FlightRecord(NamedTuple):
    """A flight every `period_s`: each array (n,), SI units, radians, our signs, angles unwrapped, NaN where missing.

    `set_steering` is the command in force from its row to the next. `command_slack_s`: it may have come this much
    later than recorded. `smoothing_s`: width of the smoothing that the heading rate needs; `smooth_both`: of the law's
    other side too.
    """

    title: str
    attribution: str
    period_s: float
    smoothing_s: float
    smooth_both: bool
    command_slack_s: float
    time_s: Array
    azimuth: Array
    elevation: Array
    course: Array
    heading: Array
    airspeed: Array
    distance: Array
    steering: Array
    set_steering: Array
    selected: Array  # True in the phase, and the time, that is to be used

    def has(self, quantity: str) -> bool:
        """Is there a value of `quantity` anywhere in the part that is used?"""
        return bool(np.isfinite(getattr(self, quantity)[self.selected]).any())

    def between(self, from_s: float, to_s: float) -> "FlightRecord":
        """The same record, with only the rows of `from_s` to `to_s` to be used."""
        return self._replace(selected=self.selected & (self.time_s >= from_s) & (self.time_s <= to_s))


def stretches(usable: Array, least: int = 1) -> Iterator[slice]:
    """The runs of at least `least` rows where `usable` (n,) is True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], usable.astype(np.int8), [0]])))
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        if stop - start >= least:
            yield slice(int(start), int(stop))


def record_from_table(table: FlightTable, description: ColumnDescription, where: str) -> FlightRecord:
    """The flight in `table` on a grid of the median time between rows; `where` names it in errors.

    Sensors that are read less often than rows are written, with empty fields or old values between, are used only at the
    times of their readings.

    Raises:
        FlightDataError: no row lies in the described phase.
    """
    if not table.selected.any():
        raise FlightDataError(f"{where}: {no_phase(description)}")
    series: dict[str, Series] = {}
    slack_s = 0.0
    for quantity, values in table.values.items():
        column = description.columns[quantity]
        time_s = table.time_s
        if quantity not in _COMMANDS:
            values = np.where(fresh_readings(values), values, np.nan)  # noqa: PLW2901
        if column.since_previous_row:
            slack_s = float(np.median(np.diff(time_s)))
            time_s = np.concatenate([time_s[:1] - slack_s, time_s[:-1]])
        series[quantity] = Series(time_s, values, column.max_gap_s)
    record = make_record(series, table.time_s, description.title, description.attribution, description.smoothing_s,
                         description.smooth_both)
    row = np.clip(np.searchsorted(table.time_s, record.time_s + 0.01 * record.period_s, "right") - 1, 0, None)
    return record._replace(selected=table.selected[row], command_slack_s=slack_s)


def make_record(series: dict[str, Series], rows_s: Array, title: str, attribution: str, smoothing_s: float,
                smooth_both: bool) -> FlightRecord:
    """A record of the quantities in `series` on the uniform grid that fits the times `rows_s` (n,) [s], growing.

    Raises:
        FlightDataError: the times have gaps so long that a grid over them would be next to empty.
    """
    check_span(rows_s, title)
    span_s = float(rows_s[-1] - rows_s[0])
    steps = round(span_s / float(np.median(np.diff(rows_s))))
    period_s = span_s / steps
    time_s = rows_s[0] + period_s * np.arange(steps + 1)
    columns = {}
    for quantity in QUANTITIES:
        if quantity in FlightRecord._fields and quantity in series:
            sampled = hold if quantity == "set_steering" else interpolate
            columns[quantity] = sampled(series[quantity], time_s, quantity in _ANGLES)
        elif quantity in FlightRecord._fields:
            columns[quantity] = np.full(len(time_s), np.nan)
    return FlightRecord(title, attribution, period_s, smoothing_s, smooth_both, 0.0, time_s,
                        selected=np.ones(len(time_s), dtype=bool), **columns)


def interpolate(series: Series, time_s: Array, angle: bool = False) -> Array:
    """`series` at `time_s` (n,), linear between readings; NaN outside of them and in long gaps.

    An `angle` is unwrapped first: it turns by less than half a circle from one reading to the next.
    """
    known = np.isfinite(series.values)
    if np.count_nonzero(known) < 2:
        return np.full(len(time_s), np.nan)
    at_s, values = series.time_s[known], series.values[known]
    values = np.unwrap(values) if angle else values
    slack_s = 1e-3 * np.median(np.diff(at_s))  # rounding of recorded times
    after = np.clip(np.searchsorted(at_s, time_s - slack_s), 1, len(at_s) - 1)
    gap_s = at_s[after] - at_s[after - 1]
    on_reading = np.minimum(np.abs(time_s - at_s[after]), np.abs(time_s - at_s[after - 1])) <= slack_s
    inside = (time_s >= at_s[0] - slack_s) & (time_s <= at_s[-1] + slack_s)
    longest_s = max(series.max_gap_s, 1.5 * np.median(np.diff(series.time_s)))
    return np.where(inside & ((gap_s <= longest_s + slack_s) | on_reading), np.interp(time_s, at_s, values), np.nan)


def hold(series: Series, time_s: Array, angle: bool = False) -> Array:
    """`series` at `time_s` (n,), each reading held until the next; NaN before the first and in long gaps."""
    del angle  # a command is none
    known = np.isfinite(series.values)
    at_s, values = series.time_s[known], series.values[known]
    if not len(at_s):
        return np.full(len(time_s), np.nan)
    slack_s = 0.01 * np.median(np.diff(time_s))
    index = np.searchsorted(at_s, time_s + slack_s, "right") - 1
    age_s = time_s - at_s[np.clip(index, 0, None)]
    return np.where((index >= 0) & (age_s <= series.max_gap_s), values[np.clip(index, 0, None)], np.nan)


def fresh_readings(values: Array) -> Array:
    """True in the rows (n,) where a sensor was read, for a sensor whose value is repeated between readings.

    A sensor is taken to be such a one if its value changes in less than every other row, as a rule. Where it is
    equal for longer than that, readings are assumed at their usual distance.
    """
    rows = np.flatnonzero(np.isfinite(values))
    fresh = np.isfinite(values)
    changed = rows[np.flatnonzero(np.concatenate([[1.0], np.diff(values[rows])]))] if len(rows) else rows
    if len(changed) < _LEAST_UPDATES or np.median(np.diff(rows)) > 1:
        return fresh
    usual = int(np.median(np.diff(changed)))
    if usual < 2:
        return fresh
    since_change = np.arange(len(values)) - changed[np.searchsorted(changed, np.arange(len(values)), "right") - 1]
    return fresh & (since_change % usual == 0)
