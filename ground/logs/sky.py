"""The sky as the pilot sees it: flight and target on the sphere, with lines of azimuth and elevation."""

from typing import Any

import numpy as np

from kite_analysis.angles import wrap
from kite_analysis.figure_eight import Array, TargetEight, unit_position

_FLOWN, _TARGET, _LINES, _TEXT = "#1f4e9c", "#d1495b", "#d5d9dd", "#8a9097"
_MARGIN = 0.06
_SIDES = 2.0  # [rad]: azimuth lines further round enter from above, and get no number


def draw_sky(axes: Any, azimuth: Array, elevation: Array, eights: list[TargetEight]) -> "View":
    """Draw the flight (n,) [rad], NaN where unknown, and its targets, the last one strongest.

    Seen from the ground point, in the azimuthal equidistant projection about the target's centre: each point has its
    true direction and great-circle distance [deg] from there, and the zenith is not an edge.
    """
    view = View(eights[-1] if eights else None, azimuth, elevation)
    for eight in eights:
        last = eight is eights[-1]
        right, up = view.project(*eight.angles(np.linspace(0.0, 2 * np.pi, 400)))
        axes.plot(right, up, "--", color=_TARGET, lw=1.3 if last else 0.8, alpha=1.0 if last else 0.5, zorder=3,
                  label="target" if last else None)
    right, up = view.project(azimuth, elevation)
    axes.plot(right, up, color=_FLOWN, lw=0.9, label="flown")
    axes.plot(right[:1], up[:1], "o", color=_FLOWN, ms=5, label="start")
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(_MARGIN)
    axes.set(xticks=[], yticks=[], xlabel="view downwind [deg]: azimuth along the edges, elevation left of the middle")
    return view


def draw_lines(axes: Any, view: "View") -> None:
    """Draw lines of azimuth and elevation with their numbers; call it when the figure's layout is final."""
    limits = axes.get_xlim(), axes.get_ylim()
    (left, right), (bottom, top) = limits
    width = min(right - left, 2 * (top - bottom))
    step = next((step for step in (5, 10, 15, 30) if width / step < 9), 45)
    around = view.azimuth + np.radians(np.linspace(-180.0, 180.0, 721))
    for elevation in range(0, 90, step):
        level = np.full_like(around, np.radians(elevation))
        _add_line(axes, view.project(around, level), 1.4 if elevation == 0 else 0.7)
        beside = np.array([view.azimuth + np.radians(step / 2)])  # beside the crossing of the eight
        _add_number(axes, view.project(beside, level[:1]), limits, f"{elevation}")
    upwards = np.linspace(0.0, np.pi / 2, 181)
    for azimuth in range(-180 + step, 181, step):
        line = view.project(np.full_like(upwards, np.radians(azimuth)), upwards)
        _add_line(axes, line, 0.7)
        if abs(wrap(np.radians(azimuth) - view.azimuth)) < _SIDES:
            _add_number(axes, line, limits, f"{azimuth}")
    _add_line(axes, view.project(np.array([0.0]), np.array([np.pi / 2])), 0.0)


class View:
    """The projection about the target's centre, or about the middle of the flight if there is no target."""

    def __init__(self, eight: TargetEight | None, azimuth: Array, elevation: Array) -> None:
        if eight is not None:
            self.azimuth, self.elevation = eight.azimuth, eight.elevation
        else:
            x, y, z = np.nanmean(unit_position(azimuth, elevation), axis=0)
            self.azimuth = float(np.arctan2(y, x))
            self.elevation = float(np.arctan2(z, np.hypot(x, y)))
        self._centre = unit_position(np.array(self.azimuth), np.array(self.elevation))
        self._up = unit_position(np.array(self.azimuth), np.array(self.elevation + np.pi / 2))
        self._right = np.cross(self._centre, self._up)

    def project(self, azimuth: Array, elevation: Array) -> tuple[Array, Array]:
        """Degrees to the right and up from the centre."""
        position = unit_position(azimuth, elevation)
        right, up = position @ self._right, position @ self._up
        across = np.hypot(right, up)
        distance = np.degrees(np.arctan2(across, position @ self._centre))
        scale = distance / np.where(across > 0.0, across, 1.0)
        return scale * right, scale * up


def _add_line(axes: Any, line: tuple[Array, Array], width: float) -> None:
    """Draw a line that does not change the limits of the axes; with width 0, a cross."""
    from matplotlib.lines import Line2D  # noqa: PLC0415  (an extra, loaded when the first plot is drawn)

    axes.add_artist(Line2D(*line, color=_LINES, lw=width, marker=None if width else "+", ms=6, zorder=0))


def _add_number(axes: Any, line: tuple[Array, Array], limits: Any, text: str) -> None:
    """Write the line's number where it enters the axes."""
    right, up = line
    (least_right, most_right), (lowest, highest) = limits
    inset = _MARGIN / 3 * (highest - lowest)
    seen = ((right > least_right + inset) & (right < most_right - inset)
            & (up > lowest + inset) & (up < highest - inset))
    if seen.any():
        at = int(np.argmax(seen))
        axes.text(right[at], up[at], text, color=_TEXT, fontsize=7, ha="center", va="center", zorder=4,
                  bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8})
