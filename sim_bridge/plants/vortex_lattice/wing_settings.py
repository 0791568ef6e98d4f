"""The scenario's section `wing`, and the settings of the kite of the vortex lattice.

Defaults are an arc of 5 m^2, a small surf kite.
"""

from dataclasses import dataclass

from sim_bridge.plants.tether_settings import TetherSettings, line_length, longest_step
from sim_bridge.settings import Settings, number, part, whole_number


@dataclass(frozen=True, kw_only=True)
class WingSettings(Settings):
    """An arc-shaped wing, its bridle and its lattice."""

    span_m: float = number(4.6, "length of the wing along its arc [m]", 0.5, 50.0)
    arc_rad: float = number(2.8, "angle of the arc, from tip to tip [rad]", 0.01, 3.1)
    root_chord_m: float = number(1.2, "chord at the centre [m]", 0.1, 10.0)
    tip_chord_m: float = number(0.85, "chord at the tips [m]", 0.05, 10.0)
    tip_sweep_m: float = number(0.3, "sweep: how far the leading edge lies back at the tips [m]", -5.0, 5.0)
    camber: float = number(0.06, "camber of the sections, over the chord", -0.2, 0.2)
    steering_twist_deg: float = number(20.0, "twist of a tip for full steering [deg]", -30.0, 30.0)
    bridle_height_m: float = number(4.0, "height of the wing's centre above the bridle point [m]", 0.1, 50.0)
    bridle_forward_m: float = number(0.25, "leading edge at the centre in front of the bridle point [m]", -5.0, 5.0)
    bridle_drag_m2: float = number(0.08, "drag coefficient times area of the bridle's lines [m^2]", 0.0, 5.0)
    mass_kg: float = number(2.2, "mass of the wing [kg]", 0.1, 200.0)
    pod_mass_kg: float = number(0.4, "mass at the bridle point [kg]", 0.0, 200.0)
    profile_drag: float = number(0.09, "profile drag coefficient of a section", 0.0, 1.0)
    greatest_lift: float = number(1.8, "maximum lift coefficient of a section", 0.1, 10.0)
    strips: int = whole_number(16, "strips of panels along the span", 4, 64)
    rows: int = whole_number(3, "rows of panels along the chord", 1, 16)


@dataclass(frozen=True, kw_only=True)
class VortexLatticeSettings(Settings):
    """The wing on its tether."""

    line_length_m: float = line_length()
    step_s: float = longest_step()
    wing: WingSettings = part(WingSettings)
    tether: TetherSettings = part(TetherSettings)
