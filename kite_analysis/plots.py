"""Plots of flights and of the theory."""

from typing import Any

import numpy as np

from kite_analysis.angles import wrap
from kite_analysis.delay.inner_loop import lambert_w_real_part
from kite_analysis.figure_eight import Array, TargetEight
from kite_analysis.figures import legend_above, new_figure
from kite_analysis.metrics import Track

_FLOWN = "#1f4e9c"
_TARGET = "#d1495b"
_GREY = "#9aa0a6"
_DASHED = (0, (3, 2))


def draw_trajectory(axes: Any, track: Track, eight: TargetEight) -> None:
    """Elevation over azimuth, as seen from the ground point looking downwind, with the target."""
    azimuth, elevation = np.degrees(eight.angles(np.linspace(0, 2 * np.pi, 400)))
    axes.plot(azimuth, elevation, ls=_DASHED, color=_TARGET, lw=1.2, zorder=3, label="target")
    axes.plot(np.degrees(track.azimuth), np.degrees(track.elevation), color=_FLOWN, lw=0.9, label="flown")
    axes.plot(np.degrees(track.azimuth[:1]), np.degrees(track.elevation[:1]), "o", color=_FLOWN, ms=4, label="start")
    axes.set(xlabel="azimuth [deg]", ylabel="elevation [deg]")
    axes.set_aspect("equal", adjustable="datalim")
    if not axes.xaxis_inverted():
        axes.invert_xaxis()  # the view is downwind: azimuth grows to the left
    axes.grid(alpha=0.3)
    legend_above(axes)


def draw_turning_angle(axes: Any, time_s: Array, course: Array, target: Array, labels: tuple[str, str] | None = None
                       ) -> None:
    """Turning angle (solid) with target (dashed) over time, without the jumps where either wraps."""
    unwrapped = np.unwrap(course)
    nearest = unwrapped + wrap(target - unwrapped)
    nearest[1:][np.abs(np.diff(nearest)) > np.pi] = np.nan
    flown, aim = labels or (r"flown $\theta$", r"target $\theta_t$")
    axes.plot(time_s, np.degrees(nearest), ls=_DASHED, color=_TARGET, lw=1.0, zorder=3, label=aim)
    axes.plot(time_s, np.degrees(unwrapped), color=_FLOWN, lw=1.0, label=flown)
    axes.set(xlabel="time [s]", ylabel="turning angle [deg]")
    axes.grid(alpha=0.3)
    axes.yaxis.get_major_locator().set_params(steps=[1, 1.8, 3, 4.5, 9, 10])  # parts of a turn
    legend_above(axes)


def draw_lambert_w(axes: Any) -> None:
    """Real part of the branches -5 to 5 of the Lambert W function, the principal one in bold."""
    a = np.linspace(-3.0, 3.0, 1201)
    a = a[a != 0.0]
    for branch in range(-5, 6):
        if branch:
            axes.plot(a, lambert_w_real_part(a, branch), color=_GREY, lw=0.8)
    axes.plot(a, lambert_w_real_part(a, 0), color="black", lw=2.2, label="principal branch")
    for x, text in ((-np.pi / 2, r"$-\pi/2$"), (-1 / np.e, r"$-1/e$")):
        axes.axvline(x, color=_TARGET, lw=0.8, ls=":")
        axes.annotate(text, (x, 1.8), color=_TARGET, ha="right", va="top", fontsize=9)
    axes.axhline(0.0, color="black", lw=0.5)
    axes.set(xlabel="$a$", ylabel=r"$\mathrm{Re}\,W_k(a)$", xlim=(-3, 3), ylim=(-6, 2))
    axes.grid(alpha=0.3)
    axes.legend(loc="lower right", fontsize=8)


def plot_flight(track: Track, eight: TargetEight, title: str) -> Any:
    """A figure with trajectory, turning angle, cross-track error and steering of one flight."""
    figure, _ = new_figure(8.0, 10.5)
    figure.clear()
    sky, *below = figure.subplots(4, 1, height_ratios=[1.5, 1.0, 0.7, 0.7])
    angle, error, steering = below
    draw_trajectory(sky, track, eight)
    draw_turning_angle(angle, track.time_s, track.course, track.target_course)
    error.plot(track.time_s, np.degrees(track.cross_track), color=_FLOWN, lw=0.9)
    error.set(ylabel="cross-track\nerror [deg]")
    error.set_ylim(bottom=0.0)
    steering.plot(track.time_s, track.steering, color=_FLOWN, lw=0.9)
    steering.set(ylabel="actual steering")
    for axes in below:
        axes.set_xlabel("")
        axes.margins(x=0.01)
        axes.grid(alpha=0.3)
        axes.tick_params(labelbottom=axes is steering)
    steering.set_xlabel("time [s]")
    figure.align_ylabels(below)
    figure.suptitle(title)
    return figure
