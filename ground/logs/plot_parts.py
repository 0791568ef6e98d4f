"""Parts that the plots of logs share: stretches of equal values, gaps, legends."""

from typing import Any

import numpy as np

from kite_analysis.figure_eight import Array

_GAP_S = 0.5  # no line is drawn over a longer silence


def runs(time_s: Array, values: Array) -> list[tuple[float, float, float]]:
    """Stretches of equal values: start and end [s], and the value."""
    if not time_s.size:
        return []
    edges = np.flatnonzero(np.diff(values)) + 1
    starts, ends = np.concatenate([[0], edges]), np.concatenate([edges, [len(values) - 1]])
    return [(float(time_s[start]), float(time_s[end]), float(values[start]))
            for start, end in zip(starts, ends, strict=True)]


def broken(time_s: Array, *lines: Array) -> list[Array]:
    """The same, with a gap where nothing came for longer than _GAP_S."""
    steps_s = np.diff(time_s)
    usual_s = float(np.median(steps_s)) if steps_s.size else 0.0
    at = np.flatnonzero(steps_s > max(_GAP_S, 3.0 * usual_s))
    return [np.insert(values, at + 1, np.nan) for values in (time_s, *lines)]


def legend(axes: Any, *others: Any) -> None:
    """Above the axes, at the right: inside, it would hide the flight."""
    handles, labels = axes.get_legend_handles_labels()
    for other in others:
        more_handles, more_labels = other.get_legend_handles_labels()
        handles, labels = handles + more_handles, labels + more_labels
    if handles:
        axes.legend(handles, labels, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(labels), fontsize=8,
                    frameon=False, borderaxespad=0.2)
