"""The scenario's section `four_point`: what the four-point kite has beside the section `kite`.

Defaults are the kite of the reference: settings and test values of the MIT-licensed KiteModels and KiteUtils (KPS4).
"""

from sim_bridge.settings import Key, number

FOUR_POINT_KEYS: dict[str, Key] = {
    "four_point.height_m": number(2.23, "from the middle of the tips up to the top [m]", 0.05, 50.0),
    "four_point.bridle_height_m": number(4.9, "from the pod up to the middle of the tips [m]", 0.1, 100.0),
    "four_point.width_m": number(4.9622, "from tip to tip [m]", 0.1, 100.0),
    "four_point.nose_distance": number(0.2, "from the middle of the tips to the nose, over the width", 0.02, 2.0),
    "four_point.nose_share": number(0.47, "fraction of the kite's mass in the nose", 0.01, 0.98),
    "four_point.top_share": number(0.4, "fraction of the remaining mass in the top; the tips share the "
                                        "rest", 0.01, 0.98),
    "four_point.alpha_zero_deg": number(4.0, "added to the angle of attack of the top [deg]", -20.0, 20.0),
    "four_point.alpha_tip_deg": number(10.0, "added to the angle of attack of the tips [deg]", -20.0, 30.0),
    "four_point.steering_deg": number(
        16.834, "change of the tips' angles of attack at full steering, up and down (k_s) [deg]", 0.0, 60.0),
    "four_point.drag_correction": number(0.93, "factor on the drag coefficients", 0.0, 5.0),
    "four_point.stiffness_n": number(
        269980.62, "stiffness of the kite's springs: force over strain; 55 GPa in lines of 2.5 mm [N]", 1e3, 1e8),
    "four_point.damping_n_s": number(473.0, "damping of the kite's springs: force over rate of strain [N s]", 1.0, 1e6),
    "four_point.compression": number(0.25, "fraction of the springs' stiffness that remains in compression", 0.01, 1.0),
    "four_point.extension_damping": number(6.0, "factor on the springs' damping in extension", 0.0, 100.0),
}
