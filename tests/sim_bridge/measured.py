"""What tests of sensors measure: a kite that hovers, one that flies, and the samples of them."""

import math
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from protocol.messages import KiteSensors
from sim_bridge.equipment.error_settings import EXACT, ErrorSettings, MeasurementErrors
from sim_bridge.equipment.sensor_settings import SensorSettings
from sim_bridge.equipment.sensors import Sensors
from sim_bridge.flight.flight import Flight
from sim_bridge.plants.truth import Truth
from sim_bridge.runtimes.inproc import InprocRuntime
from sim_bridge.runtimes.tick_output import clock_us
from sim_bridge.scenario.scenario import load_scenario

PERIOD_S = 0.02
PLAIN = SensorSettings()
QUANTITIES = "azimuth", "elevation", "distance", "course", "heading", "airspeed", "tether_force", "steering"
CIRCULAR = "azimuth", "course", "heading"


class Moment(NamedTuple):
    """The truth at a tick, the actual steering with it."""

    time_s: float
    truth: Truth
    steering: float


def hovering(seconds: float) -> list[Moment]:
    """A kite that stands still at an elevation of 0.6 rad, on 60 m of tether with 800 N."""
    position = (math.cos(0.6) * math.cos(0.3), math.cos(0.6) * math.sin(0.3), math.sin(0.6))
    truth = Truth(position, (0.0, 0.0, 0.0), -0.4, -0.5, 60.0, 12.0, 800.0)
    return [Moment(PERIOD_S * tick, truth, 0.1) for tick in range(round(seconds / PERIOD_S))]


@cache
def flying() -> list[Moment]:
    """Twenty seconds of eights, each of which takes the course through downwards to both sides, past pi."""
    flight = Flight(load_scenario("small-kite-one-point"), InprocRuntime())
    flight.fly(0.0)
    moments = []
    for _ in range(1000):
        moments.append(Moment(flight.time_s, flight.plant.truth(), flight.actuator.position))
        flight.step()
    return moments


def only(section: str, errors: ErrorSettings) -> MeasurementErrors:
    """Errors of one quantity alone."""
    return EXACT._replace(**{section: errors})


def measured(moments: Sequence[Moment], errors: MeasurementErrors = EXACT,
             settings: SensorSettings = PLAIN, seed: int = 1) -> list[KiteSensors]:
    """The samples of `moments`, taken with these errors."""
    sensors = Sensors(settings, seed, errors)
    samples = []
    for time_s, truth, steering in moments:
        sensors.follow(time_s, truth, steering)
        if sensors.is_due(time_s):
            samples.append(KiteSensors._make(sensors.sample(clock_us(time_s), truth, steering)))
    return samples


def column(samples: Sequence[NamedTuple], quantity: str) -> np.ndarray:
    """One quantity of all samples, as an array."""
    return np.array([getattr(sample, quantity) for sample in samples])


def error(moments: Sequence[Moment], quantity: str, errors: MeasurementErrors) -> np.ndarray:
    """What is measured of one quantity less what is measured without errors, angles within half a turn."""
    wrong = column(measured(moments, errors), quantity)
    right = column(measured(moments), quantity)
    difference = wrong - right
    return np.remainder(difference + math.pi, math.tau) - math.pi if quantity in CIRCULAR else difference
