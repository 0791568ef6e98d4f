"""The scenario's section `actuator`."""

from dataclasses import dataclass
from math import inf

from sim_bridge.settings import Settings, number


@dataclass(frozen=True, kw_only=True)
class ActuatorSettings(Settings):
    """A steering actuator; by default it does what is asked at once."""

    dead_time_s: float = number(0.0, "dead time from command to actual steering [s]", 0.0, 5.0)
    rate_limit_per_s: float = number(0.0, "maximum rate of the steering [1/s]; 0 is no limit", 0.0, 1000.0)
    saturation: float = number(0.0, "maximum steering to either side; 0 is no limit", 0.0, 10.0)
    lag_s: float = number(0.0, "time constant of a first-order lag [s]; 0 is none", 0.0, 5.0)
    dead_band: float = number(
        0.0, "least difference between command and position for which the motor starts; it stops at the command",
        0.0, 2.0)
    backlash: float = number(
        0.0, "play between motor and steering: how far the motor turns after a reversal before the steering follows",
        0.0, 2.0)

    @property
    def reach(self) -> float:
        """The greatest actual steering: the motor's, less half the play behind it."""
        return max(0.0, self.saturation - 0.5 * self.backlash) if self.saturation else inf
