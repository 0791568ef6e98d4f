"""Gusts along the wind: a first-order Gauss-Markov process, the simplest of Dryden's forms."""

from math import exp, sqrt
from random import Random

from sim_bridge.scenario import Scenario


class Turbulence:
    """`along` is the gust over the mean wind: mean 0, and the turbulence intensity as its standard deviation."""

    def __init__(self, scenario: Scenario, period_s: float):
        self._intensity = scenario["wind.turbulence_intensity"]
        self._keep = exp(-period_s / scenario["wind.turbulence_time_s"])
        self._random = Random(f"{scenario['run.seed']}:turbulence")
        self._state = self._random.gauss(0.0, 1.0)
        self.along = self._intensity * self._state

    def advance(self) -> None:
        """Move on by one period, exactly."""
        if self._intensity:
            self._state = self._keep * self._state + sqrt(1.0 - self._keep**2) * self._random.gauss(0.0, 1.0)
            self.along = self._intensity * self._state
