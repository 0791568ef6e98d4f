"""The scenario's section `four_point`, and the settings of the four-point kite, which has the section `kite`, too.

Defaults are the kite of the reference: settings and test values of the MIT-licensed KiteModels and KiteUtils (KPS4).
"""

from dataclasses import dataclass

from sim_bridge.plants.kite_settings import KiteSettings
from sim_bridge.plants.tether_settings import TetherSettings, line_length, longest_step
from sim_bridge.settings import Settings, number, part


@dataclass(frozen=True, kw_only=True)
class FourPointFrame(Settings):
    """The kite's shape between its four points, its springs and the angles of its surfaces."""

    height_m: float = number(2.23, "from the middle of the tips up to the top [m]", 0.05, 50.0)
    bridle_height_m: float = number(4.9, "from the pod up to the middle of the tips [m]", 0.1, 100.0)
    width_m: float = number(4.9622, "from tip to tip [m]", 0.1, 100.0)
    nose_distance: float = number(0.2, "from the middle of the tips to the nose, over the width", 0.02, 2.0)
    nose_share: float = number(0.47, "fraction of the kite's mass in the nose", 0.01, 0.98)
    top_share: float = number(0.4, "fraction of the remaining mass in the top; the tips share the rest", 0.01, 0.98)
    alpha_zero_deg: float = number(4.0, "added to the angle of attack of the top [deg]", -20.0, 20.0)
    alpha_tip_deg: float = number(10.0, "added to the angle of attack of the tips [deg]", -20.0, 30.0)
    steering_deg: float = number(
        16.834, "change of the tips' angles of attack at full steering, up and down (k_s) [deg]", 0.0, 60.0)
    drag_correction: float = number(0.93, "factor on the drag coefficients", 0.0, 5.0)
    stiffness_n: float = number(
        269980.62, "stiffness of the kite's springs: force over strain; 55 GPa in lines of 2.5 mm [N]", 1e3, 1e8)
    damping_n_s: float = number(473.0, "damping of the kite's springs: force over rate of strain [N s]", 1.0, 1e6)
    compression: float = number(0.25, "fraction of the springs' stiffness that remains in compression", 0.01, 1.0)
    extension_damping: float = number(6.0, "factor on the springs' damping in extension", 0.0, 100.0)


@dataclass(frozen=True, kw_only=True)
class FourPointSettings(Settings):
    """The four-point kite on its tether."""

    line_length_m: float = line_length()
    step_s: float = longest_step()
    kite: KiteSettings = part(KiteSettings)
    four_point: FourPointFrame = part(FourPointFrame)
    tether: TetherSettings = part(TetherSettings)
