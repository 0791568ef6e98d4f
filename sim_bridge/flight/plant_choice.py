"""Makes a plant by its name."""

import os
import threading
import time
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec

from kite_analysis.figure_eight import TargetEight
from sim_bridge.flight.start_state import start_position
from sim_bridge.plants.interface import Plant
from sim_bridge.plants.truth import Vector
from sim_bridge.scenario.scenario import Scenario
from sim_bridge.wind.air import Air

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
    module, name = _PLANTS[scenario.plant_kind]
    kite = getattr(import_module(f"sim_bridge.plants.{module}"), name)
    return kite(scenario.plant, scenario.wind, position, direction)


def slowness(kind: str) -> str | None:
    """The warning before a flight of a plant that could be compiled but is not; None if there is nothing to warn of."""
    if kind == "turning-rate":
        return None
    if find_spec("numba") is None:
        return (f"without numba the {kind} plant flies at about real time: "
                "pip install 'kitepilot[fast]' makes it about 50 times faster")
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return (f"NUMBA_DISABLE_JIT is set: the {kind} plant flies at about real time, "
                "about 50 times slower than without it")
    return None


def warm_up(scenario: Scenario, notice: Callable[[str], None]) -> None:
    """Have the scenario's plant compiled before the flight; `notice` is told if that takes a while.

    Raises:
        ScenarioError: as `make_plant`.
    """
    kind = scenario.plant_kind
    if kind == "turning-rate":
        return
    if slow := slowness(kind):
        notice(slow)
        return
    waiting = threading.Timer(1.5, notice, [f"compiling the {kind} plant (once per machine)"])
    waiting.daemon = True
    begin = time.monotonic()
    waiting.start()
    try:
        eight = TargetEight.from_parameters(scenario.parameter)
        plant = make_plant(scenario, *start_position(scenario.start, eight))
        plant.step(1e-4, 0.0, Air(scenario.wind.speed_m_s))
    finally:
        waiting.cancel()
    if (took_s := time.monotonic() - begin) > 1.5:
        notice(f"compiled in {took_s:.1f} s and cached")
