"""The wind of a flight, tick by tick."""

from sim_bridge.scenario import Scenario
from sim_bridge.wind.air import Air
from sim_bridge.wind.turbulence import Turbulence


class Wind:
    """`air` is the wind at the time reached so far."""

    def __init__(self, scenario: Scenario, period_s: float):
        self._speed = scenario["wind.speed_m_s"]
        self._turbulence = Turbulence(scenario, period_s)
        self.air = Air(self._speed, 0.0, self._turbulence.along)

    def advance(self) -> None:
        """Move on by one period."""
        self._turbulence.advance()
        self.air = Air(self._speed, 0.0, self._turbulence.along)
