"""The scenario's section `kite`, and the settings of the one-point kite, which has it and the tether.

Defaults are the kite of the reference, area 10.18 m^2. Sources: U. Fechner et al., "Dynamic model of a pumping kite
power system" (2015); settings of the MIT-licensed KiteUtils.
"""

from dataclasses import dataclass

from sim_bridge.plants.tether_settings import TetherSettings, line_length, longest_step
from sim_bridge.settings import Settings, number, numbers, part

_LIFT_ANGLES, _LIFT = zip(
    (-180.0, 0.0), (-160.0, 0.5), (-90.0, 0.0), (-20.0, 0.08), (-10.0, 0.125), (-5.0, 0.15), (0.0, 0.2), (20.0, 1.0),
    (40.0, 1.0), (90.0, 0.0), (160.0, -0.5), (180.0, 0.0), strict=True)
_DRAG_ANGLES, _DRAG = zip(
    (-180.0, 0.5), (-170.0, 0.5), (-140.0, 0.5), (-90.0, 1.0), (-20.0, 0.2), (0.0, 0.1), (20.0, 0.2), (90.0, 1.0),
    (140.0, 0.5), (170.0, 0.5), (180.0, 0.5), strict=True)


@dataclass(frozen=True, kw_only=True)
class KiteSettings(Settings):
    """A kite whose forces come from polars."""

    area_m2: float = number(10.18, "projected area [m^2]", 0.1, 1000.0)
    mass_kg: float = number(6.2, "mass of the kite [kg]", 0.05, 1000.0)
    pod_mass_kg: float = number(8.4, "mass of the control pod below it [kg]", 0.0, 1000.0)
    depower: float = number(
        0.25, "relative length of the depower line; 0.236 leaves the angle of attack unchanged", 0.0, 0.6)
    lift_angles_deg: tuple[float, ...] = numbers(_LIFT_ANGLES, "angles of attack of the lift coefficients [deg]", 180.0)
    lift_coefficients: tuple[float, ...] = numbers(_LIFT, "lift coefficients at those angles", 10.0)
    drag_angles_deg: tuple[float, ...] = numbers(_DRAG_ANGLES, "angles of attack of the drag coefficients [deg]", 180.0)
    drag_coefficients: tuple[float, ...] = numbers(_DRAG, "drag coefficients at those angles", 10.0)
    side_area: float = number(0.306, "area of the side force, over the projected area", 0.0, 2.0)
    bridle_length_m: float = number(33.4, "total length of the bridle lines [m]", 0.0, 1000.0)
    bridle_diameter_m: float = number(0.0025, "diameter of the bridle lines [m]", 0.0, 0.05)
    steering_force: float = number(2.59, "one-point: side-force coefficient at full steering (c_s)", 0.0, 50.0)
    gravity_correction_m_s: float = number(
        0.93, "one-point: airspeed times steering that reduces the gravity term (c2_cor) [m/s]", 0.0, 50.0)
    bridle_drag: float = number(1.1, "one-point: drag factor for the bridle at the kite", 0.0, 10.0)
    steering_drag: float = number(0.6, "one-point: fraction that full steering adds to the drag", 0.0, 10.0)


@dataclass(frozen=True, kw_only=True)
class OnePointSettings(Settings):
    """The one-point kite on its tether."""

    line_length_m: float = line_length()
    step_s: float = longest_step()
    kite: KiteSettings = part(KiteSettings)
    tether: TetherSettings = part(TetherSettings)
