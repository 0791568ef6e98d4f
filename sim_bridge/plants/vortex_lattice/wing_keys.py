"""The scenario's section `wing`: the kite of the vortex lattice. Defaults are an arc of 5 m^2, a small surf kite."""

from sim_bridge.settings import Key, number

WING_KEYS: dict[str, Key] = {
    "wing.span_m": number(4.6, "length of the wing along its arc [m]", 0.5, 50.0),
    "wing.arc_rad": number(2.8, "angle of the arc, from tip to tip [rad]", 0.01, 3.1),
    "wing.root_chord_m": number(1.2, "chord at the centre [m]", 0.1, 10.0),
    "wing.tip_chord_m": number(0.85, "chord at the tips [m]", 0.05, 10.0),
    "wing.tip_sweep_m": number(0.3, "sweep: how far the leading edge lies back at the tips [m]", -5.0, 5.0),
    "wing.camber": number(0.06, "camber of the sections, over the chord", -0.2, 0.2),
    "wing.steering_twist_deg": number(20.0, "twist of a tip for full steering [deg]", -30.0, 30.0),
    "wing.bridle_height_m": number(4.0, "height of the wing's centre above the bridle point [m]", 0.1, 50.0),
    "wing.bridle_forward_m": number(0.25, "leading edge at the centre in front of the bridle point [m]", -5.0, 5.0),
    "wing.bridle_drag_m2": number(0.08, "drag coefficient times area of the bridle's lines [m^2]", 0.0, 5.0),
    "wing.mass_kg": number(2.2, "mass of the wing [kg]", 0.1, 200.0),
    "wing.pod_mass_kg": number(0.4, "mass at the bridle point [kg]", 0.0, 200.0),
    "wing.profile_drag": number(0.09, "profile drag coefficient of a section", 0.0, 1.0),
    "wing.greatest_lift": number(1.8, "maximum lift coefficient of a section", 0.1, 10.0),
    "wing.strips": Key(16, "strips of panels along the span", 4, 64, kind=int),
    "wing.rows": Key(3, "rows of panels along the chord", 1, 16, kind=int),
}
