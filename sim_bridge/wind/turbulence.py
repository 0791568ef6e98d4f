"""Gusts over the mean wind, tick by tick: along, across, upwards."""

from math import exp, sqrt
from random import Random
from typing import Final, Protocol

from sim_bridge.wind.gust_process import LongitudinalGust, TransverseGust
from sim_bridge.wind.gust_scales import GustScales, dryden_parts, gust_scales
from sim_bridge.wind.profile import LAWS, profile_factor
from sim_bridge.wind.wind_settings import FIRST_ORDER, WindSettings

_LEAST_CONVECTION: Final = 0.1  # so that time constants are finite [m/s]


class Turbulence(Protocol):
    """`gusts` are (along, across, vertical) over the mean wind, with the turbulence intensity as deviation along."""

    gusts: tuple[float, float, float]

    def advance(self) -> None:
        """Move on by one period, exactly."""
        ...


def make_turbulence(settings: WindSettings, period_s: float, seed: int, mean_speed: float, height: float
                    ) -> Turbulence:
    """The turbulence that the settings name, in a wind of `mean_speed` [m/s] at 6 m, as felt at `height` [m]."""
    if settings.gusts == FIRST_ORDER:
        return FirstOrderTurbulence(settings, period_s, seed)
    return FrozenTurbulence(settings, period_s, seed, mean_speed, height)


class FirstOrderTurbulence:
    """Along the wind only: a first-order Gauss-Markov process of a given correlation time."""

    def __init__(self, settings: WindSettings, period_s: float, seed: int):
        self._intensity = settings.turbulence_intensity
        self._keep = exp(-period_s / settings.turbulence_time_s)
        self._random = Random(f"{seed}:turbulence")
        self._state = self._random.gauss(0.0, 1.0)
        self.gusts = (self._intensity * self._state, 0.0, 0.0)

    def advance(self) -> None:
        """Move on by one period, exactly."""
        if self._intensity:
            self._state = self._keep * self._state + sqrt(1.0 - self._keep**2) * self._random.gauss(0.0, 1.0)
            self.gusts = (self._intensity * self._state, 0.0, 0.0)


class FrozenTurbulence:
    """Dryden's or von Karman's gusts, frozen in the air (Taylor) and carried past the kite at one speed.

    That speed, the lengths and the intensities belong to one height, that of the eight's centre, and stay as they are
    for the whole flight, so that the gusts over the mean wind are a stationary process. The speed is the mean wind's
    there unless the settings give another: what a mast at that place would measure. A kite that crosses the wind meets
    the gusts faster, by about its airspeed over the wind speed.
    """

    def __init__(self, settings: WindSettings, period_s: float, seed: int, mean_speed: float, height: float):
        kind, length = settings.gusts, settings.turbulence_length_m
        scales = GustScales(length, length, 1.0) if length else gust_scales(kind, height)
        convection = settings.convection_m_s or max(
            _LEAST_CONVECTION, mean_speed * profile_factor(LAWS[settings.profile], settings.exponent, height))

        def parts(length: float) -> list[tuple[float, float]]:
            return [(share, factor * length / (convection * period_s)) for share, factor in dryden_parts(kind)]

        def stream(component: str) -> Random:
            return Random(f"{seed}:turbulence.{component}")

        self._intensity = settings.turbulence_intensity
        self._vertical_intensity = self._intensity * scales.vertical_share
        self._along = LongitudinalGust(parts(scales.horizontal), stream("along"))
        self._across = TransverseGust(parts(scales.horizontal), stream("across"))
        self._vertical = TransverseGust(parts(scales.vertical), stream("vertical"))
        self.gusts = self._gusts()

    def advance(self) -> None:
        """Move on by one period, exactly."""
        if self._intensity:
            self._along.advance()
            self._across.advance()
            self._vertical.advance()
            self.gusts = self._gusts()

    def _gusts(self) -> tuple[float, float, float]:
        return (self._intensity * self._along.value, self._intensity * self._across.value,
                self._vertical_intensity * self._vertical.value)
