"""The choice of a plant by its name."""

from importlib import import_module

from sim_bridge.plants.interface import Plant, Vector
from sim_bridge.scenario import Scenario

# Loaded when flown: the compiler that some need takes a while to load.
_PLANTS = {
    "turning-rate": ("turning_rate", "TurningRatePlant"),
    "one-point": ("one_point", "OnePointKite"),
    "four-point": ("four_point", "FourPointKite"),
    "vortex-lattice": ("vortex_lattice.plant", "VortexLatticeKite"),
}


def make_plant(scenario: Scenario, position: Vector, direction: Vector) -> Plant:
    """The plant that the scenario names, at a unit `position`, flying in the unit tangent `direction`.

    Raises:
        ScenarioError: it cannot fly there, with the reason.
    """
    module, name = _PLANTS[scenario["plant.kind"]]
    return getattr(import_module(f"sim_bridge.plants.{module}"), name)(scenario, position, direction)
