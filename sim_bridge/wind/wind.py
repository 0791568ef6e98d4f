"""The wind of a flight, tick by tick."""

from sim_bridge.wind.air import Air
from sim_bridge.wind.schedule import Schedule
from sim_bridge.wind.turbulence import make_turbulence
from sim_bridge.wind.wind_file import WindFile
from sim_bridge.wind.wind_settings import WindSettings


class MeanWind:
    """The wind without its gusts: that of the settings or of their file, and what is planned for it.

    `speed_m_s` is its mean before anything is planned [m/s]; `is_steady` if it never changes.

    Raises:
        ScenarioError: the wind file is invalid.
    """

    def __init__(self, settings: WindSettings):
        self._speed = settings.speed_m_s
        self._file = WindFile(settings.file, settings.file_repeat) if settings.file else None
        self._schedule = Schedule(settings)
        self.speed_m_s = self._file.mean_speed() if self._file else self._speed
        self.is_steady = self._schedule.is_empty and not self._file

    def at(self, time_s: float) -> tuple[float, float, float]:
        """Speed [m/s], direction [rad] and vertical wind over speed, at `time_s` of the flight."""
        speed, direction, rising = self._file.at(time_s) if self._file else (self._speed, 0.0, 0.0)
        return self._schedule.speed(speed, time_s), direction + self._schedule.turned(time_s), rising


class Wind:
    """`air` is the wind at the time reached so far: the mean, what is planned for it, and gusts.

    It moves on in periods of `period_s`. The gusts come from `seed`; those of dryden and von-karman are as at
    `height_m`, that of the eight's centre.

    Raises:
        ScenarioError: there is a file for the wind, and something is wrong with it.
    """

    def __init__(self, settings: WindSettings, period_s: float, seed: int, height_m: float):
        self._period_s = period_s
        self._tick = 0
        self._mean = MeanWind(settings)
        self._turbulence = make_turbulence(settings, period_s, seed, self._mean.speed_m_s, height_m)
        self._steady = self._mean.is_steady and not settings.turbulence_intensity
        self.air = self._air()

    def advance(self) -> None:
        """Move on by one period."""
        if self._steady:
            return
        self._tick += 1
        self._turbulence.advance()
        self.air = self._air()

    def _air(self) -> Air:
        speed, direction, rising = self._mean.at(self._tick * self._period_s)
        along, across, vertical = self._turbulence.gusts
        return Air(speed, direction, along, across, rising + vertical)
