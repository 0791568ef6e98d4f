"""The kites that can be flown, and the choice of one by its name."""

from sim_bridge.plants.interface import Plant, Vector
from sim_bridge.plants.turning_rate import TurningRatePlant
from sim_bridge.scenario import Scenario

_PLANTS = {"turning-rate": TurningRatePlant}


def make_plant(scenario: Scenario, position: Vector, direction: Vector) -> Plant:
    """The plant that the scenario names, at a unit `position`, its nose in the unit tangent `direction`."""
    return _PLANTS[scenario["plant.kind"]](scenario, position, direction)
