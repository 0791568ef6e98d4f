"""The numbers by which a flight is judged, the same for simulated and for real ones."""

from typing import NamedTuple

import numpy as np

from analysis.target_eight import Array, TargetEight, unit_position, wrap

UNSTABLE_TURNING_ANGLE = 1.2  # [rad]
UNSTABLE_SATURATION = 0.3


class Track(NamedTuple):
    """A flight, sampled at the ticks of the control loop; each array (n,), angles in radians."""

    time_s: Array
    azimuth: Array
    elevation: Array
    course: Array
    target_course: Array
    steering: Array  # actual
    at_limit: Array  # 1 where the steering sits at its limit, else 0


class Metrics(NamedTuple):
    """What a flight was like after it had settled."""

    cross_track_rms_rad: float
    cross_track_max_rad: float
    turning_angle_rms_rad: float
    steering_rms: float
    saturated_fraction: float
    verdict: str


def measure(track: Track, eight: TargetEight, settle_s: float) -> Metrics:
    """Metrics of `track` against `eight` after `settle_s`; over all of it if it is shorter than that."""
    used = track.time_s >= settle_s
    if not used.any():
        used = np.ones_like(used)
    part = Track(*(values[used] for values in track))
    if not all(np.isfinite(values).all() for values in part):
        return Metrics(np.nan, np.nan, np.nan, np.nan, np.nan, "unstable")
    _, cross_track = eight.nearest(unit_position(part.azimuth, part.elevation))
    angle_rms = _rms(wrap(part.target_course - part.course))
    saturated = float(np.mean(part.at_limit))
    unstable = angle_rms > UNSTABLE_TURNING_ANGLE or saturated > UNSTABLE_SATURATION
    return Metrics(
        _rms(cross_track), float(np.max(cross_track)), angle_rms, _rms(part.steering), saturated,
        "unstable" if unstable else "tracking")


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
