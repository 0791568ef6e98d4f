"""The law on the plants: flown, identified, and how K depends on wind, line and depower."""

import math
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from kite_analysis.console.tables import table, with_std
from kite_analysis.flights.description import FlightDataError
from kite_analysis.flights.reader import read_record
from kite_analysis.flights.record import FlightRecord
from kite_analysis.identification.turning_rate_fit import LawFit, identify_law
from sim_bridge.errors import FirmwareError, ScenarioError
from sim_bridge.runs.run import RunOptions, run_scenario
from sim_bridge.scenario.keys import plants_that_know
from sim_bridge.scenario.plant_names import PLANTS
from sim_bridge.scenario.scenario import Scenario, load_scenario
from sim_bridge.studies.paper import paper_flights

Notice = Callable[[str], None]
FAMILY = "small-kite"
_SETTLE_S = 10.0
_LENGTH_S = 70.0
# What is varied, on which plants: key, values, and the parameters that follow the key.
_VARIED: tuple[tuple[str, tuple[float, ...]], ...] = (
    ("wind.speed_m_s", (6.0, 7.0, 8.0, 9.0)),
    ("plant.line_length_m", (40.0, 60.0, 80.0, 120.0)),
    ("kite.depower", (0.22, 0.25, 0.28, 0.31)),
)


class Flown(NamedTuple):
    """A flight of a plant: its numbers, and what was identified on heading and on course."""

    numbers: dict[str, Any]
    record: FlightRecord
    heading: LawFit
    course: LawFit

    @property
    def airspeed(self) -> float:
        """Mean apparent wind speed [m/s]."""
        return float(np.mean(self.record.airspeed[self.record.selected]))


def set_of(plant: str) -> str:
    """The small kite's set for `plant`."""
    return FAMILY if plant == "turning-rate" else f"{FAMILY}-{plant}"


def fly_and_identify(scenario: Scenario, notice: Notice) -> Flown:
    """Fly the scenario for a minute and identify its law from the log.

    Raises:
        ScenarioError, FirmwareError: it cannot be flown.
        FlightDataError: the flight does not determine the law, or ended early.
    """
    scenario.set("run.duration_s", _LENGTH_S, "validate")
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "log"
        numbers = run_scenario(scenario, RunOptions(log=log), notice=notice).numbers
        if numbers["trouble"]:
            raise FlightDataError(numbers["trouble"])
        record = read_record(log).between(_SETTLE_S, math.inf)
    return Flown(numbers, record, identify_law(record, "heading"), identify_law(record, "course"))


def closed_loop_table(notice: Notice) -> str:
    """The four sets in steady and in turbulent wind, and how fast they fly."""
    rows = []
    for plant in PLANTS:
        name = set_of(plant)
        cells = [plant, f"`{name}`"]
        for intensity in (0.0, 0.15):
            scenario = load_scenario(name)
            scenario.set("wind.turbulence_intensity", intensity, name)
            scenario.set("run.duration_s", 120.0, name)
            numbers = run_scenario(scenario, RunOptions(), notice=notice).numbers
            cells.append(f"{numbers['verdict']}, {math.degrees(numbers['cross_track_rms_rad']):.2f}")
        rows.append([*cells, f"{numbers['real_time_factor']:.0f}"])
        notice(f"{name}: flown in steady and in turbulent wind")
    return table(("plant", "set", "steady wind [deg RMS]", "turbulence 0.15 [deg RMS]", "times real time"), rows)


def law_table(notice: Notice) -> str:
    """Where the law holds: K, gravity, R2 and lag of each set and of the reference's kites."""
    rows = []
    for name in (*map(set_of, PLANTS), "reference-kite-one-point", "reference-kite-four-point"):
        flown = fly_and_identify(load_scenario(name), notice)
        fit = flown.heading
        rows.append([f"`{name}`", f"{flown.airspeed:.1f}", with_std(fit.k_rad_per_m, fit.k_rad_per_m_std, 4),
                     with_std(fit.gravity_m_s2, fit.gravity_m_s2_std, 2), with_std(fit.lag_s, None, 2),
                     f"{fit.r2:.4f}", f"{flown.course.r2:.4f}"])
        notice(f"{name}: identified")
    return table(("set", "airspeed [m/s]", "K [rad/m]", "gravity [m/s²]", "lag [s]", "R² on heading", "R² on course"),
                 rows)


def variation_table(key: str, values: Sequence[float], notice: Notice) -> str:
    """K, with the mean airspeed and R2, of each plant over the values of `key`."""
    plants = [plant for plant in PLANTS[1:] if plant in plants_that_know(key)]
    rows = []
    for value in values:
        rows.append([f"{value:g}", *(_varied(plant, key, value, notice) for plant in plants)])
        notice(f"{key} = {value:g}: flown")
    return table((f"`{key}`", *plants), rows)


def _varied(plant: str, key: str, value: float, notice: Notice) -> str:
    scenario = load_scenario(set_of(plant))
    try:
        if key == "plant.line_length_m":  # the firmware's length reaches to the wing
            bridle_m = scenario.parameter("LINE_LENGTH") - scenario.plant.line_length_m
            scenario.set_parameter("LINE_LENGTH", value + bridle_m, key)
        scenario.set(key, value, key)
        flown = fly_and_identify(scenario, notice)
    except (ScenarioError, FirmwareError, FlightDataError) as error:
        return f"does not fly: {error}"
    return f"{flown.heading.k_rad_per_m:.3f} at {flown.airspeed:.1f} m/s, R² {flown.heading.r2:.3f}"


def variation_tables(notice: Notice) -> str:
    """All variations, one table after the other."""
    return "".join(variation_table(key, values, notice) for key, values in _VARIED)


def paper_table(notice: Notice) -> str:
    """The paper's three flights on every plant."""
    rows = []
    for plant in PLANTS:
        cells = [plant]
        flights = paper_flights(plant)
        for flight in flights:
            numbers = run_scenario(flight.scenario, RunOptions(), notice=notice).numbers
            cells.append(f"{numbers['verdict']}, {numbers['cross_track_rms_rad']:.3f}")
        rows.append([*cells, f"{flights[-1].scenario.link.control.delay_s:g}"])
        notice(f"the paper's flights on {plant}: flown")
    return table(("plant", "no delay, P 10 [rad RMS]", "delay, P 10 [rad RMS]", "delay, P 1/(e τ) [rad RMS]", "τ [s]"),
                 rows)
