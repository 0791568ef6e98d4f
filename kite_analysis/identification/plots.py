"""Plots of an identification: measured values against the fitted law and actuator."""

from typing import Any

import numpy as np

from kite_analysis.figure_eight import Array
from kite_analysis.figures import legend_above, new_figure
from kite_analysis.flights.record import FlightRecord
from kite_analysis.identification.actuator_fit import ActuatorFit, cut_blocks
from kite_analysis.identification.turning_rate_fit import LawFit, fitted_rate, rows_for
from kite_analysis.identification.turning_rates import LawRows, regressors

_MEASURED = "#8a9099"
_FITTED = "#d1495b"
_SET = "#2a7f62"


def plot_identification(record: FlightRecord, law: LawFit, actuator: ActuatorFit | None) -> Any:
    """A figure: rate over time, steering over time (where there is an actuator), and the rate over Va u."""
    figure, _ = new_figure(10.0, 10.0 if actuator else 7.5)
    figure.clear()
    data = rows_for(record, law)
    heights = [1.0, 0.8, 1.0] if actuator else [1.0, 1.0]
    grid = figure.add_gridspec(len(heights), 2, height_ratios=heights)
    top = figure.add_subplot(grid[0, :])
    _draw_rate(top, record, law, data, actuator is not None)
    if actuator:
        _draw_steering(figure.add_subplot(grid[1, :], sharex=top), record, actuator)
    _draw_line(figure.add_subplot(grid[-1, 0]), law, data)
    _draw_residual(figure.add_subplot(grid[-1, 1]), law, data)
    figure.suptitle(f"{record.title}: turning-rate law on the {law.angle}, R² {law.r2:.4f}")
    if record.attribution:
        figure.supxlabel(record.attribution, x=0.995, ha="right", fontsize=6, color="#666666")
    return figure


def _draw_rate(axes: Any, record: FlightRecord, law: LawFit, data: LawRows, below: bool) -> None:
    """Rate over time; `below`: another plot over the same time stands below."""
    time_s = record.time_s[data.rows]
    for values, style, label in ((data.rate, _MEASURED, "measured"),
                                 (fitted_rate(data, law), _FITTED, "law")):
        axes.plot(*_broken(time_s, np.degrees(values), record.period_s), color=style, label=label,
                  lw=2.2 if style == _MEASURED else 0.9)
    axes.set(ylabel=f"{law.angle} rate [deg/s]")
    if below:
        axes.tick_params(labelbottom=False)
    else:
        axes.set_xlabel("time [s]")
    _finish(axes)


def _draw_steering(axes: Any, record: FlightRecord, actuator: ActuatorFit) -> None:
    blocks = cut_blocks(record)
    position = blocks.run(actuator.model)
    rows = (blocks.starts + np.arange(len(position))[:, None]).T[blocks.used.T]
    used = np.sort(rows)
    axes.plot(*_broken(record.time_s[used], record.set_steering[used], record.period_s), color=_SET, lw=0.9,
              drawstyle="steps-post", label="commanded")
    axes.plot(*_broken(record.time_s[used], record.steering[used], record.period_s), color=_MEASURED, lw=2.2,
              label="actual")
    axes.plot(*_broken(record.time_s[rows], position.T[blocks.used.T], record.period_s), color=_FITTED, lw=0.9,
              label=f"model: {describe_actuator(actuator)}")
    axes.set(xlabel="time [s]", ylabel="steering")
    _finish(axes)


def _draw_line(axes: Any, law: LawFit, data: LawRows) -> None:
    """What K Va u has to explain, over Va u, and the line of slope K."""
    terms = regressors(data, law.lag_s or 0.0)
    rest = data.rate - fitted_rate(data, law) + law.k_rad_per_m * terms[:, 0]
    axes.plot(terms[:, 0], np.degrees(rest), ".", color=_MEASURED, ms=2.5, alpha=0.5,
              label="measured minus the other terms")
    ends = np.array([np.min(terms[:, 0]), np.max(terms[:, 0])])
    axes.plot(ends, np.degrees(law.k_rad_per_m * ends), color=_FITTED, lw=1.4,
              label=f"K = {law.k_rad_per_m:.4f} ± {law.k_rad_per_m_std:.4f} rad/m")
    axes.set(xlabel=f"airspeed times {law.steering} steering [m/s]", ylabel="steering-induced rate [deg/s]")
    _finish(axes)


def _draw_residual(axes: Any, law: LawFit, data: LawRows) -> None:
    """What the law leaves, over what it gives."""
    fitted = np.degrees(fitted_rate(data, law))
    residual = np.degrees(data.rate) - fitted
    axes.plot(fitted, residual, ".", color=_MEASURED, ms=2.5, alpha=0.5,
              label=f"{np.sqrt(np.mean(residual**2)):.3g} deg/s RMS")
    axes.axhline(0.0, color=_FITTED, lw=1.0)
    axes.set(xlabel="rate from the law [deg/s]", ylabel="measured minus law [deg/s]")
    _finish(axes)


def describe_actuator(fit: ActuatorFit) -> str:
    """Dead time and limits in a line."""
    parts = [f"dead time {fit.dead_time_s:.2f} s"]
    if fit.rate_limit_per_s is not None:
        parts.append(f"rate limit {fit.rate_limit_per_s:.3g} 1/s")
    if fit.saturation is not None:
        parts.append(f"saturation {fit.saturation:.3g}")
    return ", ".join(parts)


def _broken(time_s: Array, values: Array, period_s: float) -> tuple[Array, Array]:
    """The same with a NaN wherever rows are missing, so that no line is drawn there."""
    gaps = np.flatnonzero(np.diff(time_s) > 1.5 * period_s) + 1
    return np.insert(time_s, gaps, np.nan), np.insert(values, gaps, np.nan)


def _finish(axes: Any) -> None:
    """Grid, and the legend above the axes, where it hides nothing."""
    axes.grid(alpha=0.3)
    axes.margins(x=0.01)
    legend_above(axes)
