"""Scenarios: TOML files with plant, links, parameters and everything else that decides a flight."""

import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from typing import Any

from protocol.parameter_table import load_parameters
from protocol.single_precision import float32
from sim_bridge.errors import ScenarioError
from sim_bridge.scenario.keys import KEYS, plants_that_know
from sim_bridge.scenario.sections import Sections
from sim_bridge.settings import Value, near_miss, read_number


class Scenario(Sections):
    """A resolved scenario: `values` by dotted key, and `parameters` by name (float32, all others at their default).

    Parts of a flight get their settings from its sections, such as `scenario.actuator`; see Sections.
    """

    def __init__(self, name: str):
        super().__init__({key: entry.default for key, entry in KEYS.items()})
        self.name = name
        self.parameters: dict[str, float] = {}

    def set(self, key: str, value: Value, where: str) -> None:
        """Set a key; errors name `where` (a file, an option).

        Raises:
            ScenarioError: no such key, or an invalid value.
        """
        if key not in KEYS:
            raise ScenarioError(f"{where}: no key {key}{near_miss(key, KEYS)}")
        with _named(where):
            self.values[key] = KEYS[key].checked(key, value)

    def set_parameter(self, name: str, value: float, where: str) -> None:
        """Set a firmware parameter, as `set` does a key."""
        table = load_parameters()
        if name not in table:
            raise ScenarioError(f"{where}: no parameter {name}{near_miss(name, table)}")
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ScenarioError(f"{where}: {name} takes a number, not {value!r}")
        problem = "is read-only" if table[name].read_only else table[name].problem_with(value)
        if problem:
            raise ScenarioError(f"{where}: {problem if name in problem else f'{name} {problem}'}")
        self.parameters[name] = float32(value)

    def parameter(self, name: str) -> float:
        """Value of a firmware parameter in this scenario."""
        return self.parameters.get(name, load_parameters()[name].default)

    def set_text(self, assignment: str, option: str) -> None:
        """Take `section.key=value` or, for option --param, `NAME=value`, as typed."""
        key, equals, text = assignment.partition("=")
        key, text, where = key.strip(), text.strip(), f"{option} {assignment}"
        if not equals or not text:
            raise ScenarioError(f"{where}: write {'NAME=value' if option == '--param' else 'section.key=value'}")
        if option == "--param":
            with _named(where):
                number = read_number(text)
            self.set_parameter(key, number, where)
        else:
            with _named(where):
                value = KEYS[key].read(key, text) if key in KEYS else text
            self.set(key, value, where)
            self.check_meaning(key, where)

    def check_meaning(self, key: str, where: str) -> None:
        """Raises ScenarioError if `key` has no effect on the scenario's plant."""
        kind, plants = self.plant_kind, plants_that_know(key)
        if kind not in plants:
            raise ScenarioError(f"{where}: {key} is for plant.kind = {' or '.join(plants)}, not {kind}")

    def to_dict(self) -> dict[str, Any]:
        """All of it, defaults included, for a run log; `set` names the parameters that are set, if to their default."""
        parameters = {name: self.parameter(name) for name, entry in load_parameters().items() if not entry.read_only}
        return {"name": self.name, "values": dict(self.values), "parameters": parameters, "set": list(self.parameters)}

    @classmethod
    def from_dict(cls, content: dict[str, Any], where: str) -> "Scenario":
        """The inverse of `to_dict`, even if the defaults have changed since.

        Raises:
            ScenarioError: it is not a scenario, or holds something unknown to this version.
        """
        try:
            scenario = cls(str(content["name"]))
            for key, value in content["values"].items():
                if value is not None:
                    scenario.set(key, value, where)
                elif key in KEYS and KEYS[key].default is None:
                    scenario.values[key] = None
            parameters = content["parameters"]
            given = content.get("set", parameters)
            for name, value in parameters.items():
                if name in given or name not in load_parameters() or value != scenario.parameter(name):
                    scenario.set_parameter(name, value, where)
        except (KeyError, TypeError, AttributeError) as error:
            raise ScenarioError(f"{where}: not a scenario: {error}") from error
        return scenario


def scenario_names() -> list[str]:
    """Names of the scenarios that come with the project."""
    folder = resources.files("sim_bridge") / "scenario" / "sets"
    return sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml"))


def load_scenario(name: str) -> Scenario:
    """Read a scenario by its name, or from a TOML file by its path.

    Raises:
        ScenarioError: there is none of that name, the TOML is broken, a key or value is wrong.
    """
    if name.endswith(".toml"):
        path = Path(name)
        try:
            return parse_scenario(path.stem, path.read_text("utf-8"), str(path))
        except (OSError, UnicodeDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else "not UTF-8 text"
            raise ScenarioError(f"{path}: {reason}") from error
    names = scenario_names()
    if name not in names:
        raise ScenarioError(f"no scenario {name}{near_miss(name, names)}; kite-sitl list shows all")
    text = (resources.files("sim_bridge") / "scenario" / "sets" / f"{name}.toml").read_text("utf-8")
    return parse_scenario(name, text, f"{name}.toml")


def set_for_plant(scenario: Scenario, kind: str, notice: Callable[[str], None]) -> Scenario:
    """The set of kite, line and eight that comes with the project for flying its `scenario` with the plant `kind`.

    small-kite and one-point give small-kite-one-point.

    Raises:
        ScenarioError: no such plant, or no set for it.
    """
    with _named(f"--set plant.kind={kind}"):
        KEYS["plant.kind"].checked("plant.kind", kind)
    if scenario.plant_kind == kind:
        return scenario
    family = scenario.name.removesuffix(f"-{scenario.plant_kind}")
    name = family if kind == "turning-rate" else f"{family}-{kind}"
    if name not in scenario_names():
        sets = [other for other in scenario_names() if load_scenario(other).plant_kind == kind]
        raise ScenarioError(f"--set plant.kind={kind}: {scenario.name} has no set for it; there are {', '.join(sets)}")
    notice(f"flying {name}, the set of kite, tether and eight for this plant")
    return load_scenario(name)


def parse_scenario(name: str, text: str, where: str) -> Scenario:
    """Read a scenario from the text of a TOML file called `where`."""
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{where}: broken TOML: {error}") from error
    scenario = Scenario(name)
    parameters = content.pop("parameters", {})
    if not isinstance(parameters, dict):
        raise ScenarioError(f"{where}: parameters is a section")
    pairs = _flatten(content)
    for key, value in pairs:
        scenario.set(key, value, where)
    for key, _ in pairs:
        scenario.check_meaning(key, where)
    for parameter, value in parameters.items():
        scenario.set_parameter(parameter, value, where)
    return scenario


def _flatten(content: dict[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    pairs = []
    for key, value in content.items():
        pairs += _flatten(value, f"{prefix}{key}.") if isinstance(value, dict) else [(prefix + key, value)]
    return pairs


@contextmanager
def _named(where: str) -> Iterator[None]:
    """Have what is wrong with a value say `where` it stands."""
    try:
        yield
    except ValueError as error:
        raise ScenarioError(f"{where}: {error}") from None
