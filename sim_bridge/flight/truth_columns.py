"""The columns of truth.csv in a run log: where the kite really was, tick by tick."""

from typing import NamedTuple


class TruthRow(NamedTuple):
    """The truth at a tick.

    From `state_course_rad` to `path_parameter_rad`, and `status`, it is what the firmware's last KITE_STATE said, nan
    where there was none; the mode is the last heartbeat's, -1 long after that; the wind is that at 6 m with its gusts
    along, before the profile.
    """

    time_s: float
    azimuth_rad: float
    elevation_rad: float
    course_rad: float
    heading_rad: float
    airspeed_m_s: float
    steering: float
    state_course_rad: float
    target_course_rad: float
    cross_track_rad: float
    path_parameter_rad: float
    steering_asked: float
    status: float
    mode: float
    distance_m: float
    tether_force_n: float
    wind_m_s: float
    wind_direction_rad: float


COLUMNS = TruthRow._fields
