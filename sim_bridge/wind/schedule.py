"""Planned changes of the mean wind: a step, a lull, a turn."""

from math import cos, pi, radians

from sim_bridge.wind.wind_settings import WindSettings


class Schedule:
    """Step, lull and turn as functions of time.

    A step is sharp, as for a step response. Lull and turn begin and end smoothly, along half a cosine. `is_empty` if
    nothing is planned.
    """

    def __init__(self, settings: WindSettings):
        self._step_s, self._step = settings.step_s, settings.step_m_s
        self._lull_s, self._lull_length = settings.lull_start_s, settings.lull_length_s
        self._ramp, self._lull_to = settings.lull_ramp_s, settings.lull_to
        self._turn_s, self._turn = settings.turn_start_s, radians(settings.turn_by_deg)
        self._turn_length = 0.5 * pi * abs(self._turn) / radians(settings.turn_rate_deg_s)
        self.is_empty = not (self._step or self._lull_length or self._turn)

    def speed(self, speed: float, time_s: float) -> float:
        """Mean wind [m/s] after step and lull, from a mean `speed` [m/s]."""
        if self._step and time_s >= self._step_s:
            speed = max(0.0, speed + self._step)
        if self._lull_length:
            back_s = self._lull_s + self._ramp + self._lull_length
            fallen = _eased(time_s - self._lull_s, self._ramp) - _eased(time_s - back_s, self._ramp)
            speed *= 1.0 - fallen + fallen * self._lull_to
        return speed

    def turned(self, time_s: float) -> float:
        """How far the wind has turned [rad]."""
        return self._turn * _eased(time_s - self._turn_s, self._turn_length) if self._turn else 0.0


def _eased(since: float, length: float) -> float:
    """From 0 to 1 in `length` [s], along half a cosine: fastest in the middle, by pi/2 over the mean."""
    if since >= length:  # first, for a ramp of no length
        return 1.0 if since >= 0.0 else 0.0
    return 0.5 - 0.5 * cos(pi * since / length) if since > 0.0 else 0.0
