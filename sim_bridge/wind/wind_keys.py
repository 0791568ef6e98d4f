"""The scenario's section `wind`."""

from sim_bridge.settings import Key, number
from sim_bridge.wind.profile import LAWS

GUSTS = ("first-order", "dryden", "von-karman")

_FILE = (
    "CSV file of the mean wind: columns time_s, speed_m_s (6 m above ground; in the place of speed_m_s), and if you "
    "like direction_deg and vertical_m_s; step, lull, turn and gusts come on top; a path from the working directory")

WIND_KEYS: dict[str, Key] = {
    "wind.speed_m_s": number(8.0, "mean wind speed, 6 m above ground [m/s]", 0.0, 60.0),
    "wind.profile": Key("constant", "profile of the mean wind over height", choices=tuple(LAWS), kind=str),
    "wind.exponent": number(1.0 / 7.0, "exponent of the exp and explog profiles", 0.0, 1.0),
    "wind.gusts": Key("first-order", "spectrum of the gusts; first-order is along the wind only", choices=GUSTS,
                      kind=str),
    "wind.turbulence_intensity": number(0.0, "standard deviation over mean of wind or airspeed", 0.0, 0.5),
    "wind.turbulence_time_s": number(4.0, "correlation time of first-order gusts [s]", 0.01, 1000.0),
    "wind.turbulence_length_m": number(
        None, "length scale of dryden and von-karman gusts, the same in all directions [m] "
        "(unset: lengths and intensities of MIL-F-8785C at the height of the eight)", 1.0, 5000.0),
    "wind.convection_m_s": number(
        None, "speed at which frozen dryden and von-karman gusts pass the kite [m/s] "
        "(unset: the mean wind at the height of the eight)", 0.1, 200.0),
    "wind.step_s": number(0.0, "when the mean wind steps [s]", 0.0, 1e6),
    "wind.step_m_s": number(0.0, "size of the step [m/s]; the wind never falls below 0", -60.0, 60.0),
    "wind.lull_start_s": number(0.0, "when the mean wind begins to fall [s]", 0.0, 1e6),
    "wind.lull_length_s": number(0.0, "how long the lull lasts between its ramps [s]; 0 is no lull", 0.0, 1e6),
    "wind.lull_ramp_s": number(3.0, "how long the wind takes to fall, and to recover [s]", 0.0, 1e5),
    "wind.lull_to": number(0.0, "fraction of the mean wind in the lull", 0.0, 1.0),
    "wind.turn_start_s": number(0.0, "when the wind begins to turn [s]", 0.0, 1e6),
    "wind.turn_by_deg": number(0.0, "angle of the turn [deg], positive from x to y", -360.0, 360.0),
    "wind.turn_rate_deg_s": number(3.0, "maximum rate of the turn [deg/s]", 1e-3, 360.0),
    "wind.file": Key("", _FILE, kind=str),
    "wind.file_repeat": Key(False, "repeat the file from its start (false: hold its last line)", kind=bool),
}
