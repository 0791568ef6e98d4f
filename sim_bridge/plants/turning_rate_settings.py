"""Settings of the kite that obeys the turning-rate law: the scenario's section `plant`."""

from dataclasses import dataclass

from sim_bridge.plants.tether_settings import line_length, longest_step
from sim_bridge.settings import Settings, flag, number, words

CONSTANT, GLIDE = "constant", "glide"


@dataclass(frozen=True, kw_only=True)
class TurningRateSettings(Settings):
    """The constants of the turning-rate law, and how fast the kite flies."""

    speed_law: str = words(
        CONSTANT,
        "constant: speed_over_length; glide: Va = wind * glide_ratio * cos(angle to the wind) (Erhard and Strauch)",
        (CONSTANT, GLIDE))
    turn_k: float = number(0.25, "turning-rate constant K [rad/m]", 1e-4, 100.0)
    airspeed_m_s: float = number(20.0, "apparent wind speed of the constant law [m/s]", 0.1, 200.0)
    speed_over_length: float = number(0.2, "speed over line length of the constant law [1/s]", 1e-3, 20.0)
    line_length_m: float = line_length()
    glide_ratio: float = number(5.0, "glide ratio of the glide law", 0.1, 50.0)
    gravity_m_s2: float = number(0.0, "gravity constant c2 of the turning-rate law [m/s^2]", 0.0, 50.0)
    offset_rad_s: float = number(0.0, "turning rate at neutral steering [rad/s]", -10.0, 10.0)
    transport: bool = flag(True, "neutral steering flies a great circle (meridian convergence); "
                                 "false: at constant turning angle")
    step_s: float = longest_step()
