"""Metrics and verdict of a flight, from the kite's true position."""

from typing import NamedTuple

import numpy as np

from kite_analysis.angles import wrap
from kite_analysis.figure_eight import Array
from kite_analysis.verdicts import (
    ASTRAY,
    LOST,
    NOT_MEASURED,
    TRACKING,
    UNSTABLE,
    UNSTABLE_SATURATION,
    UNSTABLE_TURNING_ANGLE,
)


class Track(NamedTuple):
    """A flight, sampled at the ticks of the control loop; each array (n,), angles in radians."""

    time_s: Array
    azimuth: Array
    elevation: Array
    course: Array
    target_course: Array  # of the outer loop at the kite's true place
    cross_track: Array  # distance to the nearest point of the curve
    steering: Array  # actual
    steering_asked: Array  # commanded
    tether_force: Array  # [N]; 0 throughout on a plant without forces
    at_limit: Array  # 1 where the steering sits at its limit, else 0
    in_track: Array  # 1 in mode TRACK, else 0
    half_width: float  # of the eight


class Metrics(NamedTuple):
    """Metrics of a flight after settling; None if there is no data.

    Travel is the sum of all changes of the steering from tick to tick, to either side, per second: of the actual one,
    and of what was asked for. The tether force is None on a plant without forces. `trouble` is why the flight is lost
    or was not measured.
    """

    cross_track_rms_rad: float | None
    cross_track_max_rad: float | None
    turning_angle_rms_rad: float | None
    steering_rms: float | None
    saturated_fraction: float | None
    steering_travel_per_s: float | None
    steering_asked_travel_per_s: float | None
    peak_tether_force_n: float | None
    least_elevation_rad: float | None
    verdict: str
    trouble: str | None


def not_measured(trouble: str | None) -> Metrics:
    """Of a flight without data."""
    return Metrics(None, None, None, None, None, None, None, None, None, NOT_MEASURED, trouble)


def measure(track: Track, settle_s: float, crash: str | None) -> Metrics:
    """Metrics and verdict from `settle_s` on; `crash` is the reason of a crash, None if there was none. See RULE."""
    measured = track.time_s >= settle_s - 1e-9
    counted = measured & (track.in_track > 0.0)
    away = measured & ~counted
    numbers = _numbers(track, counted)
    if crash:
        return numbers._replace(verdict=LOST, trouble=crash)
    if not measured.any():
        return numbers._replace(trouble=f"the flight ended before run.settle_s = {settle_s:g} s: fly longer")
    if away.any():
        return numbers._replace(verdict=LOST, trouble=_why_lost(track.time_s, measured, away))
    return numbers


def _numbers(track: Track, used: Array) -> Metrics:
    """Of the ticks that are `used`, with the verdict on them alone."""
    if not used.any():
        return not_measured(None)
    cross_track = track.cross_track[used]
    rms, turning_angle = _rms(cross_track), _rms(wrap(track.target_course - track.course)[used])
    saturated = float(np.mean(track.at_limit[used]))
    unstable = (turning_angle > UNSTABLE_TURNING_ANGLE or saturated > UNSTABLE_SATURATION
                or rms > ASTRAY * track.half_width)
    force = float(np.max(track.tether_force[used]))
    return Metrics(
        rms, float(np.max(cross_track)), turning_angle, _rms(track.steering[used]), saturated,
        _travel(track.time_s, track.steering, used), _travel(track.time_s, track.steering_asked, used),
        force if force > 0.0 else None, float(np.min(track.elevation[used])),
        UNSTABLE if unstable else TRACKING, None)


def _travel(time_s: Array, steering: Array, used: Array) -> float | None:
    """Between ticks that follow each other and are both `used`, per second; None if there are none."""
    between = used[1:] & used[:-1]
    if not between.any():
        return None
    return float(np.sum(np.abs(np.diff(steering))[between]) / np.sum(np.diff(time_s)[between]))


def _why_lost(time_s: Array, measured: Array, away: Array) -> str:
    period_s = float(np.median(np.diff(time_s))) if len(time_s) > 1 else 0.0
    return (f"not in TRACK for {away.sum() * period_s:.1f} s of the {measured.sum() * period_s:.1f} s measured, "
            f"first at {time_s[away][0]:.1f} s")


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
