"""The scenario's section `actuator`."""

from dataclasses import dataclass

from sim_bridge.settings import Settings, number


@dataclass(frozen=True, kw_only=True)
class ActuatorSettings(Settings):
    """A steering actuator; by default it does what is asked at once."""

    dead_time_s: float = number(0.0, "dead time from command to actual steering [s]", 0.0, 5.0)
    rate_limit_per_s: float = number(0.0, "maximum rate of the steering [1/s]; 0 is no limit", 0.0, 1000.0)
    saturation: float = number(0.0, "maximum steering to either side; 0 is no limit", 0.0, 10.0)
    lag_s: float = number(0.0, "time constant of a first-order lag [s]; 0 is none", 0.0, 5.0)
