"""The scenario's section `wind`."""

from dataclasses import dataclass

from sim_bridge.settings import Settings, flag, number, words
from sim_bridge.wind.profile import LAWS

FIRST_ORDER = "first-order"
GUSTS = (FIRST_ORDER, "dryden", "von-karman")

_FILE = (
    "CSV file of the mean wind: columns time_s, speed_m_s (6 m above ground; in the place of speed_m_s), and if you "
    "like direction_deg and vertical_m_s; step, lull, turn and gusts come on top; a path from the working directory")


@dataclass(frozen=True, kw_only=True)
class WindSettings(Settings):
    """The mean wind, what is planned for it, and its gusts."""

    speed_m_s: float = number(8.0, "mean wind speed, 6 m above ground [m/s]", 0.0, 60.0)
    profile: str = words("constant", "profile of the mean wind over height", tuple(LAWS))
    exponent: float = number(1.0 / 7.0, "exponent of the exp and explog profiles", 0.0, 1.0)
    gusts: str = words(FIRST_ORDER, "spectrum of the gusts; first-order is along the wind only", GUSTS)
    turbulence_intensity: float = number(0.0, "standard deviation over mean of wind or airspeed", 0.0, 0.5)
    turbulence_time_s: float = number(4.0, "correlation time of first-order gusts [s]", 0.01, 1000.0)
    turbulence_length_m: float | None = number(
        None, "length scale of dryden and von-karman gusts, the same in all directions [m] "
        "(unset: lengths and intensities of MIL-F-8785C at the height of the eight)", 1.0, 5000.0)
    convection_m_s: float | None = number(
        None, "speed at which frozen dryden and von-karman gusts pass the kite [m/s] "
        "(unset: the mean wind at the height of the eight)", 0.1, 200.0)
    step_s: float = number(0.0, "when the mean wind steps [s]", 0.0, 1e6)
    step_m_s: float = number(0.0, "size of the step [m/s]; the wind never falls below 0", -60.0, 60.0)
    lull_start_s: float = number(0.0, "when the mean wind begins to fall [s]", 0.0, 1e6)
    lull_length_s: float = number(0.0, "how long the lull lasts between its ramps [s]; 0 is no lull", 0.0, 1e6)
    lull_ramp_s: float = number(3.0, "how long the wind takes to fall, and to recover [s]", 0.0, 1e5)
    lull_to: float = number(0.0, "fraction of the mean wind in the lull", 0.0, 1.0)
    turn_start_s: float = number(0.0, "when the wind begins to turn [s]", 0.0, 1e6)
    turn_by_deg: float = number(0.0, "angle of the turn [deg], positive from x to y", -360.0, 360.0)
    turn_rate_deg_s: float = number(3.0, "maximum rate of the turn [deg/s]", 1e-3, 360.0)
    file: str = words("", _FILE)
    file_repeat: bool = flag(False, "repeat the file from its start (false: hold its last line)")
