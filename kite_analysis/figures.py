"""Empty figures, and their files. matplotlib is loaded when the first one is made."""

from pathlib import Path
from typing import Any

from kite_analysis.console.optional_packages import ExtraMissingError


def new_figure(width: float = 7.0, height: float = 4.5, rows: int = 1) -> tuple[Any, Any]:
    """An empty figure and its axes (an array of them for `rows` > 1), sizes in inches.

    Raises:
        ExtraMissingError: matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure  # noqa: PLC0415  an extra, and slow to load
    except ImportError:
        raise ExtraMissingError("plots need matplotlib: pip install 'kitepilot[plots]'") from None
    figure = Figure((width, height), dpi=150, layout="constrained")
    return figure, figure.subplots(rows, 1, sharex=rows > 1)


def legend_above(axes: Any, *others: Any, lift: float = 0.0) -> None:
    """A legend above the axes, at the right: inside, it would hide the flight. `others` add the names on their axes.

    `lift` leaves room below it, in heights of the axes.
    """
    handles, labels = axes.get_legend_handles_labels()
    for other in others:
        more_handles, more_labels = other.get_legend_handles_labels()
        handles, labels = handles + more_handles, labels + more_labels
    if handles:
        axes.legend(handles, labels, loc="lower right", bbox_to_anchor=(1.0, 1.0 + lift), ncols=len(labels), fontsize=8,
                    frameon=False, borderaxespad=0.2)


def save(figure: Any, path: Path) -> None:
    """Write `figure` to `path`; its ending names the format."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, metadata={"Software": None} if path.suffix == ".png" else None)
