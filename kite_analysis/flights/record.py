"""A recorded flight from any source: row by row as recorded, or on a uniform time grid for identification."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from kite_analysis.figure_eight import Array
from kite_analysis.flights.checks import check_span
from kite_analysis.flights.description import ColumnDescription, FlightDataError, no_phase

_ANGLES = ("azimuth", "course", "heading")  # these wrap
_STEERING = ("steering", "set_steering")
_LEAST_UPDATES = 20  # fewer changes than this do not show how often a sensor is read


class Series(NamedTuple):
    """A quantity as recorded: times [s] (m,), growing, values (m,) with NaN where missing, the longest gap [s]."""

    time_s: Array
    values: Array
    max_gap_s: float


class FlightRecord(NamedTuple):
    """A flight: each array (n,), SI units, radians, our signs, NaN where missing. `period_s`: the usual row spacing.

    On a uniform grid, as `evenly_spaced` gives it, the angles are unwrapped. `set_steering` is the command in force
    from its row to the next. `command_slack_s`: it may have come this much later than recorded. `smoothing_s`: width of
    the smoothing that the heading rate needs; `smooth_both`: of the law's other side too.
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
    tether_force: Array
    steering: Array
    set_steering: Array
    target_course: Array  # as the controller had it, and the four that follow
    cross_track: Array
    path_parameter: Array
    mode: Array  # number of KITE_MODE
    sample_age_s: Array  # of the newest sample
    selected: Array  # True in the phase, and the time, that is to be used
    further: Mapping[str, Array]  # what else there is, by the names and in the units of where it is from

    def has(self, quantity: str) -> bool:
        """Is there a value of `quantity` anywhere in the part that is used?"""
        return bool(np.isfinite(getattr(self, quantity)[self.selected]).any())

    def between(self, from_s: float, to_s: float) -> "FlightRecord":
        """The same record, with only the rows of `from_s` to `to_s` to be used."""
        return self._replace(selected=self.selected & (self.time_s >= from_s) & (self.time_s <= to_s))

    def rows(self, which: Array) -> "FlightRecord":
        """The rows `which`, as numpy takes them: a mask (n,), or indices."""
        columns: dict[str, Any] = {name: getattr(self, name)[which] for name in ("time_s", *COLUMNS, "selected")}
        return self._replace(**columns, further={name: values[which] for name, values in self.further.items()})


COLUMNS = FlightRecord._fields[FlightRecord._fields.index("time_s") + 1 : FlightRecord._fields.index("selected")]


def as_recorded(time_s: Array, columns: Mapping[str, Array], title: str = "", attribution: str = "",
                smoothing_s: float = 0.0, smooth_both: bool = True, selected: Array | None = None,
                further: Mapping[str, Array] | None = None) -> FlightRecord:
    """A flight with rows at the times (n,) [s], growing; a quantity that is not in `columns` is missing throughout."""
    all_columns = {name: columns.get(name, np.full(len(time_s), np.nan)) for name in COLUMNS}
    period_s = float(np.median(np.diff(time_s))) if len(time_s) > 1 else 0.0
    return FlightRecord(title, attribution, period_s, smoothing_s, smooth_both, 0.0, time_s, **all_columns,
                        selected=np.ones(len(time_s), dtype=bool) if selected is None else selected,
                        further=further or {})


def stretches(usable: Array, least: int = 1) -> Iterator[slice]:
    """The runs of at least `least` rows where `usable` (n,) is True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], usable.astype(np.int8), [0]])))
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        if stop - start >= least:
            yield slice(int(start), int(stop))


def evenly_spaced(flight: FlightRecord, description: ColumnDescription, where: str) -> FlightRecord:
    """A `flight` as recorded, on a grid of the median time between rows; `where` names it in errors.

    Sensors that are read less often than rows are written, with empty fields or old values between, are used only at
    the times of their readings.

    Raises:
        FlightDataError: no row lies in the described phase.
    """
    if not flight.selected.any():
        raise FlightDataError(f"{where}: {no_phase(description)}")
    series: dict[str, Series] = {}
    slack_s = 0.0
    for quantity, column in description.columns.items():
        if quantity == "time":
            continue
        time_s, values = flight.time_s, getattr(flight, quantity)
        if quantity not in _STEERING:
            values = np.where(fresh_readings(values), values, np.nan)
        if column.since_previous_row:
            slack_s = float(np.median(np.diff(time_s)))
            time_s = np.concatenate([time_s[:1] - slack_s, time_s[:-1]])
        series[quantity] = Series(time_s, values, column.max_gap_s)
    return on_a_grid(series, flight)._replace(command_slack_s=slack_s)


def on_a_grid(series: Mapping[str, Series], flight: FlightRecord) -> FlightRecord:
    """The quantities in `series` on the uniform grid that fits the rows of `flight`, with all that is said of it.

    Raises:
        FlightDataError: the times have gaps so long that a grid over them would be next to empty.
    """
    rows_s = flight.time_s
    check_span(rows_s, flight.title)
    span_s = float(rows_s[-1] - rows_s[0])
    steps = round(span_s / float(np.median(np.diff(rows_s))))
    period_s = span_s / steps
    time_s = rows_s[0] + period_s * np.arange(steps + 1)
    columns = {quantity: hold(values, time_s) if quantity == "set_steering" else
               interpolate(values, time_s, quantity in _ANGLES) for quantity, values in series.items()}
    row = np.clip(np.searchsorted(rows_s, time_s + 0.01 * period_s, "right") - 1, 0, None)
    record = as_recorded(time_s, columns, flight.title, flight.attribution, flight.smoothing_s, flight.smooth_both,
                         flight.selected[row])
    return record._replace(period_s=period_s)


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


def hold(series: Series, time_s: Array) -> Array:
    """`series` at `time_s` (n,), each reading held until the next; NaN before the first and in long gaps."""
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
