"""Profile of the mean wind over height: the laws of U. Fechner et al. (2015), as in the MIT-licensed KiteUtils.

Heights are above ground; below the reference height of 6 m the wind is taken as at 6 m.
"""

from math import cos, exp, log, sin
from typing import Final

from sim_bridge.wind.air import Air

Vector = tuple[float, float, float]

REFERENCE_HEIGHT_M: Final = 6.0
_ROUGHNESS_M: Final = 2e-4
CONSTANT: Final = 0
EXPONENTIAL: Final = 1
LOGARITHMIC: Final = 2
EXPLOG: Final = 3
LAWS = {"constant": CONSTANT, "exp": EXPONENTIAL, "log": LOGARITHMIC, "explog": EXPLOG}


def profile_factor(law: int, exponent: float, height: float) -> float:
    """Mean wind at `height` [m] over that at 6 m: 1, (h/6)^a, ln(h/z0)/ln(6/z0), or twice the third less the second."""
    if law == CONSTANT or height <= REFERENCE_HEIGHT_M:
        return 1.0
    power = (height / REFERENCE_HEIGHT_M) ** exponent
    if law == EXPONENTIAL:
        return power
    logarithmic = log(height / _ROUGHNESS_M) / log(REFERENCE_HEIGHT_M / _ROUGHNESS_M)
    return logarithmic if law == LOGARITHMIC else 2.0 * logarithmic - power


def air_density(height: float) -> float:
    """Density of air [kg/m^3] at `height` [m]: 1.225 exp(-h / 8550)."""
    return 1.225 * exp(-height / 8550.0)


def wind_at(air: Air, law: int, exponent: float, height: float) -> Vector:
    """Wind vector [m/s] in the wind frame at `height` [m]; see Air."""
    mean = air.speed_m_s * profile_factor(law, exponent, height)
    c, s = cos(air.direction_rad), sin(air.direction_rad)
    along, across = mean * air.gust, mean * air.across
    return c * along - s * across, s * along + c * across, mean * air.vertical


def air_on_tether(air: Air, law: int, exponent: float, height: float) -> tuple[float, Vector, Vector]:
    """Density [kg/m^3] and wind [m/s] at a kite's `height` [m], which may be below ground, and wind at half of it."""
    above = max(0.0, height)
    return air_density(above), wind_at(air, law, exponent, above), wind_at(air, law, exponent, 0.5 * above)
