"""Provenance of a flight: every value, the code, the versions; and what differs here."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from protocol.parameter_table import load_parameters
from sim_bridge.errors import ScenarioError
from sim_bridge.runs.fingerprint import code_fingerprints, fingerprint, versions
from sim_bridge.runtimes.interpreter import Interpreter, find_interpreter, micropython_command
from sim_bridge.scenario.keys import KEYS
from sim_bridge.scenario.scenario import Scenario

WIND_COPY = "wind.csv"


def what_decides(scenario: Scenario) -> dict[str, Any]:
    """Everything that decides the flight of `scenario`, for run.json."""
    return {
        "scenario": scenario.to_dict(), "defaults": _defaults(),
        "wind_file": wind_fingerprint(scenario.wind.file), "code": code_fingerprints(), "versions": versions(),
    }


def wind_fingerprint(path: str) -> str | None:
    """A fingerprint of the wind file's contents; None if there is no wind file.

    Raises:
        ScenarioError: it cannot be read.
    """
    if not path:
        return None
    try:
        return fingerprint(Path(path).read_bytes())
    except OSError as error:
        raise ScenarioError(f"wind.file {path}: {error.strerror}") from error


def scenario_as_logged(about: dict[str, Any], folder: Path) -> Scenario:
    """The scenario of a run.json, with its wind; keys unknown to this version are left out.

    Raises:
        ScenarioError: it holds no scenario, or its wind file is gone or changed.
    """
    where = str(folder / "run.json")
    logged = about.get("scenario")
    if not isinstance(logged, dict) or not all(isinstance(logged.get(part), dict) for part in ("values", "parameters")):
        raise ScenarioError(f"{where}: does not hold a scenario")
    known = {part: {name: value for name, value in logged[part].items() if name in table}
             for part, table in _tables().items()}
    scenario = Scenario.from_dict(logged | known, where)
    if scenario.wind.file:
        _take_wind(scenario, about.get("wind_file"), folder)
    return scenario


def interpreter_as_logged(about: dict[str, Any], given: str | None, folder: Path) -> tuple[str | None, list[str]]:
    """Path of the MicroPython that flies a run.json again, and how it differs from the logged one, in words.

    It is the one `given`, else the logged one, else the one beside Python if its floats are as wide.

    Raises:
        ScenarioError: there is none with floats as wide.
        FirmwareError: the one that is there cannot be run.
    """
    logged = about.get("interpreter")
    if not logged:
        return given, []
    was = Interpreter(**{field: logged.get(field) for field in Interpreter._fields})
    path = given or (was.path if Path(was.path).exists() else None)
    here = find_interpreter(path) if path or micropython_command() else None
    if given is None and was.float_bits != (here.float_bits if here else 64):
        raise ScenarioError(f"{folder}: flown by {was}, which is not at {was.path} now: "
                            "tell where one is by --interpreter PATH")
    return path, [f"flown by {was}, now by {here}"] if here and str(here) != str(was) else []


def differences(about: dict[str, Any]) -> list[str]:
    """What decided the flight of a run.json and differs here, in words; the values flown are those of the log."""
    if "defaults" not in about:
        return ["logged by an older version, without defaults and code fingerprint"]
    found = []
    other = [name for name, here in code_fingerprints().items() if about.get("code", {}).get(name) != here]
    if other:
        found.append(f"flown by other code: {', '.join(other)} {'differs' if len(other) == 1 else 'differ'}")
    _compare(about.get("versions", {}), versions(), found, lambda name, then, now: f"{name} was {then}, is {now}")
    for part, here in json.loads(json.dumps(_defaults())).items():
        logged, then = about["scenario"][part], about["defaults"].get(part, {})
        known = {name: value for name, value in here.items() if name in then}
        _compare(then, known, found, lambda name, then, now, logged=logged: (
            f"{name}: the default was {then}, is {now}"
            + (f"; flown with {logged[name]}, as logged" if name in logged and now != _NOTHING else "")))
        new = [name for name in here if name not in then]
        if new:
            upto = f" to {new[-1]}" if len(new) > 1 else ""
            found.append(f"new since, and flown with {'its default' if len(new) == 1 else 'their defaults'}: "
                         f"{new[0]}{upto} ({len(new)})")
    return found


_NOTHING = "not known"


def _compare(then: dict[str, Any], now: dict[str, Any], found: list[str], say: Callable[[str, Any, Any], str]) -> None:
    for name in then | now:
        old, new = (table.get(name, _NOTHING) for table in (then, now))
        if old != new:
            found.append(say(name, *("unset" if value is None else value for value in (old, new))))


def _tables() -> dict[str, Any]:
    return {"values": KEYS, "parameters": load_parameters()}


def _defaults() -> dict[str, dict[str, Any]]:
    return {part: {name: entry.default for name, entry in table.items()} for part, table in _tables().items()}


def _take_wind(scenario: Scenario, logged: str | None, folder: Path) -> None:
    """Let the scenario take the wind from the log's own copy or, if it still is what it was, from its old place."""
    for path in (folder / WIND_COPY, Path(scenario.wind.file)):
        if path.exists() and logged in (None, wind_fingerprint(str(path))):
            scenario.set("wind.file", str(path), str(folder))
            return
    raise ScenarioError(f"{folder}: its {WIND_COPY}, the wind of this flight, is missing or was changed")
