"""The wind of a flight, tick by tick."""

from sim_bridge.scenario.scenario import Scenario
from sim_bridge.wind.air import Air
from sim_bridge.wind.schedule import Schedule
from sim_bridge.wind.turbulence import make_turbulence
from sim_bridge.wind.wind_file import WindFile


class Wind:
    """`air` is the wind at the time reached so far: the mean of scenario or file, what is planned for it, and gusts.

    Raises:
        ScenarioError: the wind file is invalid.
    """

    def __init__(self, scenario: Scenario, period_s: float):
        self._speed = scenario["wind.speed_m_s"]
        self._period_s = period_s
        self._tick = 0
        self._file = WindFile(scenario["wind.file"], scenario["wind.file_repeat"]) if scenario["wind.file"] else None
        self._schedule = Schedule(scenario)
        mean_speed = self._file.mean_speed() if self._file else self._speed
        self._turbulence = make_turbulence(scenario, period_s, mean_speed)
        self._steady = self._schedule.is_empty and not self._file and not scenario["wind.turbulence_intensity"]
        self.air = self._air()

    def advance(self) -> None:
        """Move on by one period."""
        if self._steady:
            return
        self._tick += 1
        self._turbulence.advance()
        self.air = self._air()

    def _air(self) -> Air:
        time_s = self._tick * self._period_s
        speed, direction, rising = self._file.at(time_s) if self._file else (self._speed, 0.0, 0.0)
        along, across, vertical = self._turbulence.gusts
        return Air(
            self._schedule.speed(speed, time_s), direction + self._schedule.turned(time_s),
            along, across, rising + vertical)
