"""Options shared by `run`, `hil` and `sweep`: a scenario, and changes to it."""

from argparse import Namespace
from collections.abc import Callable

from sim_bridge.scenario.scenario import Scenario, load_scenario, set_for_plant


def scenario_of(options: Namespace, notice: Callable[[str], None]) -> Scenario:
    """The scenario that the options name, with their changes.

    Raises:
        ScenarioError: there is none, or a change is invalid.
    """
    scenario = load_scenario(options.scenario)
    options.set.sort(key=lambda assignment: not assignment.startswith("plant.kind"))  # other keys depend on it
    for assignment in options.set:
        key, _, kind = assignment.partition("=")
        if key.strip() == "plant.kind" and not options.scenario.endswith(".toml"):
            scenario = set_for_plant(scenario, kind.strip(), notice)
    for assignment in options.set:
        scenario.set_text(assignment, "--set")
    for assignment in options.param:
        scenario.set_text(assignment, "--param")
    if options.seed is not None:
        scenario.set("run.seed", options.seed, "--seed")
    if options.duration is not None:
        scenario.set("run.duration_s", options.duration, "--duration")
    return scenario
