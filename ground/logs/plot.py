"""The plot of a recorded flight: sky, turning angle, steering, delays, loss."""

from datetime import UTC, datetime
from typing import Any, NamedTuple

import numpy as np

from ground.logs.parameters import LoggedChange, LoggedParameters
from ground.logs.quantities import Delays, LinkQuality, delays, link_quality, recorded_flight
from ground.logs.reader import MessageLog
from ground.logs.sky import draw_lines, draw_sky
from kite_analysis.angles import wrap
from kite_analysis.figure_eight import Array, TargetEight
from kite_analysis.figures import legend_above, new_figure
from kite_analysis.flights.record import FlightRecord
from protocol import dialect
from protocol.frame import Address
from protocol.modes import mode_name

_FLOWN, _TARGET, _ACTUAL, _GREY = "#1f4e9c", "#d1495b", "#e08e2b", "#8a9097"
_BAND, _PALE = "#f4c9cf", "#9fb6d9"
_MODES = {dialect.KITE_MODE_STANDBY: "#eceff1", dialect.KITE_MODE_MANUAL: "#fdf3d8",
          dialect.KITE_MODE_PARK: "#e3f1e5", dialect.KITE_MODE_TRACK: "#ffffff"}
_NEAR = 0.04  # of the time shown: changes closer than this share a label
_MOST_LABELS = 12
_GAP_S = 0.5  # no line is drawn across a longer gap
_SMALL = 0.25  # of the limit: if all steering is smaller, the axes end above it, not above the limit
_LIMITED = dialect.KITE_STATUS_SATURATED | dialect.KITE_STATUS_SLEWED
_NAMES = 0.11  # of the axes' height: the modes' names, between the axes and the legend
_EIGHT = ("EIGHT_AZIMUTH", "EIGHT_ELEVATION", "EIGHT_HALF_W", "EIGHT_HALF_H", "EIGHT_DIRECTION")


class Flight(NamedTuple):
    """What is plotted of a flight, from `from_s` to `to_s` [s]; the record is cut to these."""

    record: FlightRecord
    delays: Delays
    quality: LinkQuality
    parameters: LoggedParameters
    from_s: float
    to_s: float
    title: str


def flight_of(log: MessageLog, vehicle: Address, from_s: float, to_s: float) -> Flight:
    """The flight of `vehicle` in `log`, from `from_s` to `to_s` [s]; its record may be empty."""
    record = recorded_flight(log, vehicle)
    first_s = from_s if from_s > 0.0 else -np.inf  # messages delayed at the log's start were sent before it
    within = (record.time_s >= first_s) & (record.time_s <= to_s)
    began = datetime.fromtimestamp(log.start_us * 1e-6, UTC)
    title = f"{log.path.name}: kite {vehicle.system}, {began:%d %B %Y %H:%M} UTC"
    return Flight(record.rows(within), delays(log, vehicle, record), link_quality(log, vehicle),
                  LoggedParameters(log, vehicle), from_s, to_s, title)


def plot_log(flight: Flight) -> Any:
    """Draw the figure.

    Raises:
        ExtraMissingError: matplotlib is not installed.
    """
    figure, _ = new_figure(10.0, 13.0)
    figure.clear()
    sky, *below = figure.subplots(5, 1, height_ratios=[1.7, 1.1, 0.9, 0.9, 0.7])
    _, azimuth, elevation = _broken(flight.record.time_s, flight.record.azimuth, flight.record.elevation)
    view = draw_sky(sky, azimuth, elevation, _eights(flight))
    legend_above(sky)
    for draw, axes in zip((_draw_turning_angle, _draw_steering, _draw_delays, _draw_loss), below, strict=True):
        _draw_modes(axes, flight.record)
        draw(axes, flight)
        axes.set_xlim(flight.from_s, flight.to_s)
        axes.grid(alpha=0.3)
    for axes in below[:-1]:
        axes.tick_params(labelbottom=False)
    below[-1].set_xlabel("time [s]")
    _name_modes(below[0], flight)
    _draw_changes(below, flight)
    figure.align_ylabels(below)
    figure.suptitle(flight.title, fontsize=12)
    figure.draw_without_rendering()
    draw_lines(sky, view)
    return figure


def _eights(flight: Flight) -> list[TargetEight]:
    """The targets that were flown; none if the log lacks some of their parameters."""
    if not set(_EIGHT) <= set(flight.parameters.names):
        return []
    changed = [change.time_s for change in flight.parameters.changes()
               if change.name in _EIGHT and flight.from_s < change.time_s <= flight.to_s]
    return list(dict.fromkeys(TargetEight.from_parameters(lambda name, at=time_s: flight.parameters.value(name, at))
                              for time_s in [flight.from_s, *changed]))


def _draw_turning_angle(axes: Any, flight: Flight) -> None:
    course = np.unwrap(flight.record.course)
    course -= 2.0 * np.pi * np.round(np.median(course) / (2.0 * np.pi))
    target = course + wrap(flight.record.target_course - course)
    time_s, course, target = _broken(flight.record.time_s, course, target)
    axes.plot(time_s, np.degrees(target), ls=(0, (3, 2)), color=_TARGET, lw=1.0, zorder=3, label=r"target $\theta_t$")
    axes.plot(time_s, np.degrees(course), color=_FLOWN, lw=1.0, label=r"flown $\theta$")
    axes.set_ylabel("turning angle [deg]")
    axes.margins(y=0.08)
    axes.yaxis.get_major_locator().set_params(steps=[1, 1.8, 3, 4.5, 9, 10])  # parts of a turn
    legend_above(axes, lift=_NAMES)


def _draw_steering(axes: Any, flight: Flight) -> None:
    record = flight.record
    limited = (record.further["status"].astype(int) & _LIMITED) != 0
    for index, (start_s, end_s, at_limit) in enumerate(_runs(record.time_s, limited)):
        if at_limit:
            axes.axvspan(start_s, end_s, color=_BAND, lw=0, zorder=0, label="limited" if index < 2 else None)
    time_s, commanded, actual = _broken(record.time_s, record.set_steering, record.steering)
    if np.isfinite(actual).any():
        axes.plot(time_s, actual, color=_ACTUAL, lw=1.0, label="actual")
    axes.plot(time_s, commanded, color=_FLOWN, lw=0.9, label="commanded")
    peak = float(np.nanmax(np.abs(np.concatenate([commanded, actual])), initial=0.0))
    most = 1.0
    if "STEER_MAX" in flight.parameters.names:
        limit = np.array([flight.parameters.value("STEER_MAX", at) for at in record.time_s])
        most = float(limit.max())
        name = f"limits, off the scale at ±{most:g}" if peak < _SMALL * most else "limits"
        for sign, label in ((1.0, name), (-1.0, None)):
            axes.plot(record.time_s, sign * limit, ":", color=_GREY, lw=1.3, label=label)
    shown = 1.12 * most if peak >= _SMALL * most else max(1.5 * peak, 0.01 * most)
    axes.set(ylabel="steering", ylim=(-shown, shown))
    legend_above(axes)


def _draw_delays(axes: Any, flight: Flight) -> None:
    found = flight.delays
    age = "age of the sample used" + ("" if found.absolute_age else ", above its minimum")
    time_s, down, old = _broken(found.state_at_s, found.telemetry_s * 1e3, found.sample_age_s * 1e3)
    axes.plot(time_s, down, ".", color=_PALE, ms=1.5)
    axes.plot([], [], ".", color=_PALE, ms=6, label="telemetry down, above its minimum")
    axes.plot(time_s, old, color=_FLOWN, lw=0.8, label=age)
    if found.round_trip_s.size:
        axes.plot(found.round_trip_at_s, found.round_trip_s * 1e3, "-o", color=_TARGET, lw=0.8, ms=2.5,
                  label="round trip")
    shown = np.concatenate([
        values[(at_s >= flight.from_s) & (at_s <= flight.to_s)] * 1e3 for at_s, values in (
            (found.state_at_s, found.telemetry_s), (found.state_at_s, found.sample_age_s),
            (found.round_trip_at_s, found.round_trip_s))])
    axes.set(ylabel="delay [ms]", ylim=(0.0, 1.1 * max(shown.max(initial=0.0), 1.0)))
    legend_above(axes)


def _draw_loss(axes: Any, flight: Flight) -> None:
    time_s, loss, rate_hz = flight.quality
    axes.fill_between(time_s, 0.0, loss * 100.0, step="mid", color=_TARGET, alpha=0.7, lw=0,
                      label="lost" if np.isfinite(loss).any() else "loss: not in this log")
    worst = float(np.nanmax(loss, initial=0.0)) * 100.0
    axes.set(ylabel="messages lost [%]", ylim=(0.0, min(max(1.2 * worst, 5.0), 100.0)))
    right = axes.twinx()
    right.plot(time_s, rate_hz, color=_GREY, lw=1.0, label="received")
    right.set_ylim(0.0, 1.3 * max(float(rate_hz.max(initial=0.0)), 1.0))
    right.set_ylabel("received [1/s]", color=_GREY)
    legend_above(axes, right)


def _draw_modes(axes: Any, record: FlightRecord) -> None:
    for start_s, end_s, mode in _runs(record.time_s, record.mode):
        axes.axvspan(start_s, end_s, color=_MODES.get(int(mode), "#ffffff"), lw=0, zorder=-1)


def _name_modes(axes: Any, flight: Flight) -> None:
    """Write the modes above these axes, where a name has room."""
    for start_s, end_s, mode in _runs(flight.record.time_s, flight.record.mode):
        if end_s - start_s > 0.06 * (flight.to_s - flight.from_s):
            axes.text(start_s, 1.02, " " + mode_name(int(mode)), transform=axes.get_xaxis_transform(), fontsize=8,
                      color=_GREY, va="bottom")


def _draw_changes(below: Any, flight: Flight) -> None:
    """A line through all axes `below` at each parameter change, labelled with old and new value."""
    changes = [change for change in flight.parameters.changes() if flight.from_s <= change.time_s <= flight.to_s]
    near_s = _NEAR * (flight.to_s - flight.from_s)
    groups: list[list[LoggedChange]] = []
    begin_s = 0.0
    for change in changes:
        if groups and change.time_s - begin_s < near_s:
            groups[-1].append(change)
        else:
            groups.append([change])
            begin_s = change.time_s
    for first, *more in groups:
        for axes in below:
            axes.axvline(first.time_s, color="black", lw=0.8, ls=(0, (4, 3)))
        if len(groups) <= _MOST_LABELS:
            text = f"{first.name} {first.before:.4g} → {first.value:.4g}" + (f", {len(more)} more" if more else "")
            below[0].text(first.time_s, 0.02, f" {text}", transform=below[0].get_xaxis_transform(), rotation=90,
                          fontsize=7, ha="right", va="bottom",
                          bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0})


def _runs(time_s: Array, values: Array) -> list[tuple[float, float, float]]:
    """Stretches of equal values: start and end [s], and the value."""
    if not time_s.size:
        return []
    edges = np.flatnonzero(np.diff(values)) + 1
    starts, ends = np.concatenate([[0], edges]), np.concatenate([edges, [len(values) - 1]])
    return [(float(time_s[start]), float(time_s[end]), float(values[start]))
            for start, end in zip(starts, ends, strict=True)]


def _broken(time_s: Array, *lines: Array) -> list[Array]:
    """The same, with NaN where no state arrived for _GAP_S."""
    steps_s = np.diff(time_s)
    usual_s = float(np.median(steps_s)) if steps_s.size else 0.0
    at = np.flatnonzero(steps_s > max(_GAP_S, 3.0 * usual_s))
    return [np.insert(values, at + 1, np.nan) for values in (time_s, *lines)]
