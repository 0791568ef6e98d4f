"""Every key that a scenario may set: its default, its bounds, and what it means.

One table serves the reading of TOML files, `--set`, and `kite-sitl keys`.
"""

from sim_bridge.plants.four_point_keys import FOUR_POINT_KEYS
from sim_bridge.plants.kite_keys import KITE_KEYS
from sim_bridge.plants.vortex_lattice.wing_keys import WING_KEYS
from sim_bridge.settings import Key, number
from sim_bridge.wind.wind_keys import WIND_KEYS

PLANTS = ("turning-rate", "one-point", "four-point", "vortex-lattice")
# What only some plants know, by key or section.
_ONLY = {
    **dict.fromkeys(("plant.speed_law", "plant.turn_k", "plant.airspeed_m_s", "plant.speed_over_length",
                     "plant.glide_ratio", "plant.gravity_m_s2", "plant.offset_rad_s", "plant.transport"), PLANTS[:1]),
    "tether": PLANTS[1:], "kite": PLANTS[1:3], "four_point": PLANTS[2:3], "wing": PLANTS[3:],
}


def _flag(default: bool, text: str) -> Key:
    return Key(default, text, kind=bool)


def _link(name: str, what: str) -> dict[str, Key]:
    """Keys of a path: for both directions together, and for each alone (those win)."""
    both = {
        "delay_s": ("delay of both directions together, half each", 30.0),
        "jitter_s": ("jitter of each direction, uniform, +-", 10.0),
        "loss": ("fraction of frames lost, in each direction", 1.0),
        "loss_burst": ("mean length of a loss burst in frames; up to 1: independent losses", 1000.0),
        "duplicate": ("fraction of frames that arrive twice", 1.0),
        "reorder": ("fraction of frames held back by reorder_s, so that others overtake them", 1.0),
        "reorder_s": ("how long a held-back frame waits", 10.0),
        "rate_bytes_s": ("capacity of the link in bytes per second; 0 is no limit", 1e9),
    }
    keys = {}
    for key, (text, greatest) in both.items():
        keys[f"link.{name}.{key}"] = number(0.1 if key == "reorder_s" else 0.0, f"{what}: {text}", 0.0, greatest)
    for direction, way in (("down", "towards the firmware"), ("up", "from the firmware")):
        for key, (text, greatest) in both.items():
            alone = "one-way delay" if key == "delay_s" else text
            note = f"{what}, {way}: {alone} (unset: as for both)"
            keys[f"link.{name}.{direction}.{key}"] = number(None, note, 0.0, greatest)
    return keys


KEYS: dict[str, Key] = {
    "title": Key("", "title of the scenario", kind=str),
    "plant.kind": Key("turning-rate", "plant to fly", choices=PLANTS, kind=str),
    "plant.speed_law": Key(
        "constant",
        "constant: speed_over_length; glide: Va = wind * glide_ratio * cos(angle to the wind) (Erhard and Strauch)",
        choices=("constant", "glide"), kind=str),
    "plant.turn_k": number(0.25, "turning-rate constant K [rad/m]", 1e-4, 100.0),
    "plant.airspeed_m_s": number(20.0, "apparent wind speed of the constant law [m/s]", 0.1, 200.0),
    "plant.speed_over_length": number(0.2, "speed over line length of the constant law [1/s]", 1e-3, 20.0),
    "plant.line_length_m": number(100.0, "line length [m]", 1.0, 2000.0),
    "plant.glide_ratio": number(5.0, "glide ratio of the glide law", 0.1, 50.0),
    "plant.gravity_m_s2": number(0.0, "gravity constant c2 of the turning-rate law [m/s^2]", 0.0, 50.0),
    "plant.offset_rad_s": number(0.0, "turning rate at neutral steering [rad/s]", -10.0, 10.0),
    "plant.transport": _flag(True, "neutral steering flies a great circle (meridian convergence); false: at constant "
                                   "turning angle"),
    "plant.step_s": number(0.01, "maximum integration step [s]; plants with forces take shorter ones where needed",
                           1e-4, 0.1),
    **WIND_KEYS,
    **KITE_KEYS,
    **FOUR_POINT_KEYS,
    **WING_KEYS,
    "tether.segments": Key(6, "segments of the tether", 1, 50, kind=int),
    "tether.diameter_m": number(0.004, "diameter of the tether [m]", 1e-4, 0.05),
    "tether.drag_coefficient": number(0.958, "drag coefficient of the tether across the flow", 0.0, 2.0),
    "tether.mass_kg_m": number(0.011, "mass of a metre of tether [kg/m]", 1e-4, 1.0),
    "tether.stiffness_n": number(614600.0, "stiffness of the tether: force over strain [N]", 100.0, 1e8),
    "tether.damping_n_s": number(473.0, "damping of the tether: force over rate of strain [N s]", 0.0, 1e6),
    "tether.compression": number(0.05, "fraction of the tether's stiffness that remains in compression", 0.0, 1.0),
    "actuator.dead_time_s": number(0.0, "dead time from command to actual steering [s]", 0.0, 5.0),
    "actuator.rate_limit_per_s": number(0.0, "maximum rate of the steering [1/s]; 0 is no limit", 0.0, 1000.0),
    "actuator.saturation": number(0.0, "maximum steering to either side; 0 is no limit", 0.0, 10.0),
    "actuator.lag_s": number(0.0, "time constant of a first-order lag [s]; 0 is none", 0.0, 5.0),
    "sensors.rate_hz": number(0.0, "samples per second; 0 is one per tick of the loop", 0.0, 1000.0),
    "sensors.noise_rad": number(0.0, "standard deviation of azimuth and elevation [rad]", 0.0, 0.5),
    "sensors.resolution_rad": number(0.0, "resolution of azimuth and elevation [rad]; 0 is unlimited", 0.0, 0.5),
    "sensors.course_noise_rad": number(0.0, "standard deviation of course and heading [rad]", 0.0, 3.0),
    "sensors.airspeed_noise": number(0.0, "relative standard deviation of the airspeed", 0.0, 1.0),
    "sensors.course": _flag(True, "the course is measured"),
    "sensors.heading": _flag(True, "the heading is measured"),
    "sensors.distance": _flag(True, "the distance is measured"),
    "sensors.airspeed": _flag(True, "the apparent wind speed is measured"),
    "sensors.steering": _flag(True, "the actual steering is measured"),
    **_link("control", "control path"),
    **_link("ground", "ground path"),
    "ground.send_to": Key("127.0.0.1:14550", "address that the kite sends to", kind=str),
    "ground.listen": Key("127.0.0.1:14551", "address that the kite listens on; port 0 is any free one", kind=str),
    "start.path_parameter": number(0.0, "where on the eight the flight starts: s [rad]", -100.0, 100.0),
    "start.offset_rad": number(0.0, "initial cross-track offset, positive to the right, towards e2 when flying up "
                                    "[rad]",
                                -1.5, 1.5),
    "start.course_error_rad": number(0.0, "initial course minus the curve's [rad]", -3.2, 3.2),
    "run.duration_s": number(60.0, "length of the flight [s]", 0.1, 1e6),
    "run.settle_s": number(10.0, "metrics start at this time [s]", 0.0, 1e6),
    "run.seed": Key(1, "seed of all random numbers", 0, 2**63 - 1, kind=int),
}


def plants_that_know(key: str) -> tuple[str, ...]:
    """The plants for which `key` means something."""
    return _ONLY.get(key) or _ONLY.get(key.partition(".")[0]) or PLANTS
