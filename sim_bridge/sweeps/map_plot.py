"""The map of a sweep: result of each flight over the first two axes, with the limits from theory."""

import math
from collections.abc import Sequence
from typing import Any, TypeGuard

import numpy as np

from kite_analysis.delay.characteristic_equation import Loop
from kite_analysis.delay.inner_loop import loop_delay, stability_limit
from kite_analysis.delay.whole_loop import gain_limit
from kite_analysis.figure_eight import Array
from kite_analysis.figures import new_figure
from kite_analysis.verdicts import LOST, NOT_MEASURED, TRACKING, UNSTABLE
from protocol.parameter_table import load_parameters
from sim_bridge.errors import ScenarioError
from sim_bridge.plants.turning_rate_settings import CONSTANT, TurningRateSettings
from sim_bridge.scenario.keys import PlantSettings
from sim_bridge.scenario.scenario import Scenario
from sim_bridge.sweeps.axes import Axis, apply

_GAIN = "param.INNER_P"
_MARKERS = {UNSTABLE: ("x", "#d1495b"), LOST: ("v", "#8d0801"), NOT_MEASURED: (".", "#9aa0a6"),
            "refused": ("+", "#9aa0a6")}
_TRACKING = "#1f4e9c"
_ERROR = "cross-track error, RMS [deg]"
_CURVE_POINTS = 80


def draw_map(base: Scenario, axes: Sequence[Axis], rows: Sequence[dict[str, str]]) -> Any:
    """A figure: cross-track RMS in colour where the kite tracked, a mark where it did not."""
    figure, plot = new_figure(7.5, 5.0)
    x = _column(axes[0], rows)
    vertical = _name(axes[1]) if len(axes) > 1 else _ERROR
    error = np.array([math.degrees(float(row["cross_track_rms_rad"] or "nan")) for row in rows])
    y = _column(axes[1], rows) if len(axes) > 1 else error
    verdicts = np.array([row["verdict"] for row in rows])
    tracking = verdicts == TRACKING
    if len(axes) == 1:
        plot.plot(x[tracking], y[tracking], "s", color=_TRACKING, ms=5, label=TRACKING)
    elif np.any(tracking):
        shades = plot.scatter(x[tracking], y[tracking], c=error[tracking], s=_size(len(rows)), marker="s",
                              cmap="viridis", norm="log" if np.any(error[tracking] > 0.0) else None)
        bar = figure.colorbar(shades, label=_ERROR, format="{x:g}")
        bar.ax.yaxis.set_minor_formatter("{x:g}")
        bar.ax.tick_params(which="both", labelsize=8)
    for verdict, (marker, colour) in _MARKERS.items():
        used = verdicts == verdict
        if np.any(used):
            plot.plot(x[used], np.nan_to_num(y[used]), marker, color=colour, ms=5, label=verdict)
    if len(axes) > 1:
        _draw_limits(plot, base, axes)
    for axis, set_scale in zip(axes, (plot.set_xscale, plot.set_yscale), strict=False):
        if axis.logarithmic:
            set_scale("log")
    plot.set(xlabel=_name(axes[0]), ylabel=vertical)
    figure.suptitle(f"{base.name}: {len(rows)} flights")
    plot.grid(alpha=0.3)
    if plot.get_legend_handles_labels()[0]:
        plot.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), fontsize=8, ncols=4, frameon=False)
    return figure


def _name(axis: Axis) -> str:
    """The key, which carries its unit; of a parameter its name, with the unit from the table."""
    name = axis.key.removeprefix("param.")
    parameter = load_parameters().get(name)
    return f"{name} [{parameter.unit}]" if parameter is not None and parameter.unit else name


def _column(axis: Axis, rows: Sequence[dict[str, str]]) -> Array:
    """The axis's values as numbers; those that are none, as their place in the list."""
    texts = [row[axis.key] for row in rows]
    try:
        return np.array([float(text) for text in texts])
    except ValueError:
        return np.array([axis.values.index(text) for text in texts], dtype=float)


def _size(count: int) -> float:
    return float(np.clip(6000.0 / count, 6.0, 80.0))


def _draw_limits(plot: Any, base: Scenario, axes: Sequence[Axis]) -> None:
    """The paper's limit on P and the whole loop's, where one of the two axes is P and the theory knows the other."""
    keys = [axis.key for axis in axes[:2]]
    if _GAIN not in keys or not _obeys_the_law(base.plant):
        return
    other = axes[1 - keys.index(_GAIN)]
    gain = axes[keys.index(_GAIN)]
    if not other.is_range:
        return
    values = np.linspace(float(other.values[0]), float(other.values[-1]), _CURVE_POINTS)
    limits = np.array([_limits(base, other, float(value)) for value in values])
    for column, (style, label) in enumerate((("--", "the paper's limit"), ("-", "limit of the whole loop"))):
        limit = limits[:, column]
        line = (limit, values) if keys[0] == _GAIN else (values, limit)
        plot.plot(*line, style, color="black", lw=1.4, label=label)
    reach = [float(value) for value in (gain.values[0], gain.values[-1])]
    margin = 0.05 * (reach[1] - reach[0])
    (plot.set_xlim if keys[0] == _GAIN else plot.set_ylim)(reach[0] - margin, reach[1] + margin)


def _limits(base: Scenario, other: Axis, value: float) -> tuple[float, float]:
    scenario = Scenario.from_dict(base.to_dict(), base.name)
    try:
        apply(scenario, [other], [repr(value)])
    except ScenarioError:
        return math.nan, math.nan
    plant, actuator = scenario.plant, scenario.actuator
    if not _obeys_the_law(plant):
        return math.nan, math.nan
    whole_s = loop_delay(actuator.dead_time_s + scenario.link.control.delay_s, scenario.parameter("LOOP_HZ"))
    loop = Loop(whole_s, plant.speed_over_length, actuator.lag_s)
    return stability_limit(whole_s), gain_limit(loop, scenario.parameter("OUTER_L"))


def _obeys_the_law(plant: PlantSettings) -> TypeGuard[TurningRateSettings]:
    """Is it the kite that the theory is for?"""
    return isinstance(plant, TurningRateSettings) and plant.speed_law == CONSTANT
