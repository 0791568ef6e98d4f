"""Length scales of gusts, and their intensities across and upwards, at a height.

Source: MIL-F-8785C (1980), section 3.7. MIL-HDBK-1797 has the same spectra; it calls half of a transverse length what
is called the length here. Below 1000 ft lengths are h / (0.177 + 0.000823 h)^1.2 horizontally and h vertically, with h
in ft, and the vertical intensity is (0.177 + 0.000823 h)^0.4 of the horizontal one. Above 2000 ft gusts are isotropic,
of 1750 ft (Dryden) or 2500 ft (von Karman); in between lengths are interpolated, as is usual.
"""

from typing import NamedTuple

from sim_bridge.wind.profile import REFERENCE_HEIGHT_M

_FOOT = 0.3048
_LOW_FT, _HIGH_FT = 1000.0, 2000.0
_HIGH_LENGTH_FT = {"dryden": 1750.0, "von-karman": 2500.0}

_VON_KARMAN = 1.339  # a, of a spectrum in (a L Omega)
_LEAST_T, _RATIO, _COUNT = 0.1, 16.0, 9


class GustScales(NamedTuple):
    """Length scales [m], and the vertical standard deviation over the horizontal one."""

    horizontal: float
    vertical: float
    vertical_share: float


def gust_scales(kind: str, height: float) -> GustScales:
    """Scales of gusts of `kind`, dryden or von-karman, at `height` [m]; below 6 m as at 6 m."""
    h = max(REFERENCE_HEIGHT_M, height) / _FOOT
    if h > _LOW_FT:
        share = min(1.0, (h - _LOW_FT) / (_HIGH_FT - _LOW_FT))
        length = _FOOT * (_LOW_FT + share * (_HIGH_LENGTH_FT[kind] - _LOW_FT))
        return GustScales(length, length, 1.0)
    base = 0.177 + 0.000823 * h
    return GustScales(_FOOT * h / base**1.2, _FOOT * h, base**0.4)


def dryden_parts(kind: str) -> list[tuple[float, float]]:
    """Gusts of `kind` as a sum of independent Dryden gusts: (share of the variance, length over L) of each.

    With z = (a L Omega)^2 von Karman's longitudinal spectrum is proportional to

        (1 + z)^(-5/6) = sin(5 pi / 6) / pi * integral from 0 to infinity of t^(-5/6) / (1 + t + z) dt,

    a sum of Dryden's longitudinal spectra of lengths a L / sqrt(1 + t), with positive weights. In isotropic
    turbulence, as both of them are, the transverse spectrum comes from the longitudinal one by a linear rule,
    (S - Omega dS/dOmega) / 2, so the same sum of Dryden's transverse spectra is von Karman's transverse one. The
    integral is taken by the trapezoidal rule in ln t, which converges exponentially; its lower end, where all lengths
    are almost a L, is one part. Within 0.5 % of both spectra up to a L Omega = 6000; they fall off faster beyond.
    """
    if kind == "dryden":
        return [(1.0, 1.0)]
    low = _LEAST_T ** (1 / 6) / (_RATIO ** (1 / 6) - 1.0)  # sums over the points below _LEAST_T: of t^(1/6) and
    mean_t = _LEAST_T ** (7 / 6) / (_RATIO ** (7 / 6) - 1.0) / low  # of t^(7/6), a mean t
    weights = [(low, mean_t)] + [(t ** (1 / 6), t) for t in (_LEAST_T * _RATIO**k for k in range(_COUNT))]
    total = 0.0
    for weight, t in weights:
        total += weight / (1.0 + t) ** 0.5
    return [(weight / (1.0 + t) ** 0.5 / total, _VON_KARMAN / (1.0 + t) ** 0.5) for weight, t in weights]
