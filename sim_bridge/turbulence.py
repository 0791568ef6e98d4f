"""Turbulence as a factor on wind or airspeed: a first-order Gauss-Markov process, the simplest of Dryden's forms."""

from math import exp, sqrt
from random import Random

from sim_bridge.scenario import Scenario


class Turbulence:
    """`factor` has mean 1 and the standard deviation of the turbulence intensity; it never falls below 0.1."""

    def __init__(self, scenario: Scenario, period_s: float):
        self._intensity = scenario["wind.turbulence_intensity"]
        self._keep = exp(-period_s / scenario["wind.turbulence_time_s"])
        self._random = Random(f"{scenario['run.seed']}:turbulence")
        self._state = self._random.gauss(0.0, 1.0)
        self.factor = self._as_factor()

    def advance(self) -> None:
        """Move on by one period, exactly."""
        if self._intensity:
            self._state = self._keep * self._state + sqrt(1.0 - self._keep**2) * self._random.gauss(0.0, 1.0)
            self.factor = self._as_factor()

    def _as_factor(self) -> float:
        return max(0.1, 1.0 + self._intensity * self._state)
