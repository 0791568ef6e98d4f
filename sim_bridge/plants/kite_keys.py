"""The scenario's section `kite`: the kites that have forces. Defaults are the kite of the reference, area 10.18 m^2.

Sources: U. Fechner et al., "Dynamic model of a pumping kite power system" (2015); settings of the MIT-licensed
KiteUtils.
"""

from sim_bridge.settings import Key, number

_LIFT = (
    (-180.0, 0.0), (-160.0, 0.5), (-90.0, 0.0), (-20.0, 0.08), (-10.0, 0.125), (-5.0, 0.15), (0.0, 0.2), (20.0, 1.0),
    (40.0, 1.0), (90.0, 0.0), (160.0, -0.5), (180.0, 0.0))
_DRAG = (
    (-180.0, 0.5), (-170.0, 0.5), (-140.0, 0.5), (-90.0, 1.0), (-20.0, 0.2), (0.0, 0.1), (20.0, 0.2), (90.0, 1.0),
    (140.0, 0.5), (170.0, 0.5), (180.0, 0.5))


def _numbers(default: tuple[float, ...], text: str, bound: float) -> Key:
    return Key(default, text, -bound, bound, kind=tuple)


def _polar(kind: str, points: tuple[tuple[float, float], ...]) -> dict[str, Key]:
    return {
        f"kite.{kind}_angles_deg": _numbers(
            tuple(angle for angle, _ in points), f"angles of attack of the {kind} coefficients [deg]", 180.0),
        f"kite.{kind}_coefficients": _numbers(
            tuple(value for _, value in points), f"{kind} coefficients at those angles", 10.0),
    }


KITE_KEYS: dict[str, Key] = {
    "kite.area_m2": number(10.18, "projected area [m^2]", 0.1, 1000.0),
    "kite.mass_kg": number(6.2, "mass of the kite [kg]", 0.05, 1000.0),
    "kite.pod_mass_kg": number(8.4, "mass of the control pod below it [kg]", 0.0, 1000.0),
    "kite.depower": number(0.25, "relative length of the depower line; 0.236 leaves the angle of attack unchanged",
                           0.0, 0.6),
    **_polar("lift", _LIFT),
    **_polar("drag", _DRAG),
    "kite.side_area": number(0.306, "area of the side force, over the projected area", 0.0, 2.0),
    "kite.bridle_length_m": number(33.4, "total length of the bridle lines [m]", 0.0, 1000.0),
    "kite.bridle_diameter_m": number(0.0025, "diameter of the bridle lines [m]", 0.0, 0.05),
    "kite.steering_force": number(2.59, "one-point: side-force coefficient at full steering (c_s)", 0.0, 50.0),
    "kite.gravity_correction_m_s": number(
        0.93, "one-point: airspeed times steering that reduces the gravity term (c2_cor) [m/s]", 0.0, 50.0),
    "kite.bridle_drag": number(1.1, "one-point: drag factor for the bridle at the kite", 0.0, 10.0),
    "kite.steering_drag": number(0.6, "one-point: fraction that full steering adds to the drag", 0.0, 10.0),
}
