"""What all plants are told of the line, and the scenario's section `tether`."""

from dataclasses import dataclass
from typing import Any

from sim_bridge.settings import Settings, number, whole_number


def line_length() -> Any:
    """The field `line_length_m` of a plant's settings."""
    return number(100.0, "line length [m]", 1.0, 2000.0)


def longest_step() -> Any:
    """The field `step_s` of a plant's settings."""
    return number(0.01, "maximum integration step [s]; plants with forces take shorter ones where needed",
                  1e-4, 0.1)


@dataclass(frozen=True, kw_only=True)
class TetherSettings(Settings):
    """A tether of elastic line; stiffness and damping are those of a metre of it: k = stiffness / l0."""

    segments: int = whole_number(6, "segments of the tether", 1, 50)
    diameter_m: float = number(0.004, "diameter of the tether [m]", 1e-4, 0.05)
    drag_coefficient: float = number(0.958, "drag coefficient of the tether across the flow", 0.0, 2.0)
    mass_kg_m: float = number(0.011, "mass of a metre of tether [kg/m]", 1e-4, 1.0)
    stiffness_n: float = number(614600.0, "stiffness of the tether: force over strain [N]", 100.0, 1e8)
    damping_n_s: float = number(473.0, "damping of the tether: force over rate of strain [N s]", 0.0, 1e6)
    compression: float = number(0.05, "fraction of the tether's stiffness that remains in compression", 0.0, 1.0)
