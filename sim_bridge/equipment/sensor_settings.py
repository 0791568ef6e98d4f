"""The scenario's section `sensors`."""

from dataclasses import dataclass

from sim_bridge.settings import Settings, flag, number


@dataclass(frozen=True, kw_only=True)
class SensorSettings(Settings):
    """Sensors of a kite; by default everything is measured exactly, at each tick."""

    rate_hz: float = number(0.0, "samples per second; 0 is one per tick of the loop", 0.0, 1000.0)
    noise_rad: float = number(0.0, "standard deviation of azimuth and elevation [rad]", 0.0, 0.5)
    resolution_rad: float = number(0.0, "resolution of azimuth and elevation [rad]; 0 is unlimited", 0.0, 0.5)
    course_noise_rad: float = number(0.0, "standard deviation of course and heading [rad]", 0.0, 3.0)
    airspeed_noise: float = number(0.0, "relative standard deviation of the airspeed", 0.0, 1.0)
    course: bool = flag(True, "the course is measured")
    heading: bool = flag(True, "the heading is measured")
    distance: bool = flag(True, "the distance is measured")
    airspeed: bool = flag(True, "the apparent wind speed is measured")
    steering: bool = flag(True, "the actual steering is measured")
