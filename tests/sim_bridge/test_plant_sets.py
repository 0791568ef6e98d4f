"""Which kite, line and eight belong to a plant, and how a flight ends that cannot go on."""

import json
import math

import pytest

from sim_bridge.cli import main as cli
from sim_bridge.errors import ScenarioError
from sim_bridge.flight.flight import Flight
from sim_bridge.runs.run import RunOptions, run_scenario
from sim_bridge.runtimes.inproc import InprocRuntime
from sim_bridge.scenario.plant_names import PLANTS
from sim_bridge.scenario.scenario import load_scenario, parse_scenario, scenario_names
from sim_bridge.studies.validation.plant_laws import fly_and_identify, set_of, variation_table

FORCES = PLANTS[1:]


def run(capsys, *options):
    code = cli.main(["run", *options, "--json"])
    out, err = capsys.readouterr()
    return code, (json.loads(out) if out else {}), err


def test_a_plant_named_on_the_command_line_brings_its_own_set(capsys):
    code, numbers, err = run(capsys, "small-kite", "--set", "tether.segments=5", "--set", "plant.kind=one-point",
                             "--duration", "3")
    assert code == 0 and "flying small-kite-one-point" in err
    assert (numbers["scenario"], numbers["plant"]) == ("small-kite-one-point", "one-point")
    code, numbers, _ = run(capsys, "small-kite-one-point", "--set", "plant.kind=turning-rate", "--duration", "3")
    assert (code, numbers["scenario"]) == (0, "small-kite")


@pytest.mark.parametrize(("options", "expected"), [
    (("v3-flight", "--set", "plant.kind=four-point"), "has no set for it; there are"),
    (("small-kite", "--set", "plant.kind=four-pint"), "did you mean four-point?"),
    (("small-kite", "--set", "kite.area_m2=6"), "is for plant.kind = one-point or four-point, not turning-rate"),
    (("small-kite-one-point", "--set", "plant.turn_k=1"), "is for plant.kind = turning-rate"),
    (("small-kite-one-point", "--set", "wind.speed_m_s=1"), "in 1.0 m/s of wind the kite cannot fly at the start"),
    (("small-kite-four-point", "--set", "wind.speed_m_s=0"), "in 0.0 m/s of wind: lift and drag are"),
    (("small-kite-vortex-lattice", "--set", "wind.speed_m_s=1"), "cannot fly steadily at the start"),
    (("small-kite-vortex-lattice", "--param", "TURN_K=0.02"), "kite manages"),
])
def test_what_cannot_be_flown_is_said_in_one_line(capsys, options, expected):
    code, numbers, err = run(capsys, *options)
    lines = [line for line in err.splitlines() if "compil" not in line]
    assert code == 2 and not numbers and len(lines) == 1
    assert expected in lines[0]


def test_a_file_with_a_key_of_another_plant_is_refused():
    with pytest.raises(ScenarioError, match=r"wing\.span_m is for plant.kind = vortex-lattice"):
        parse_scenario("mine", '[plant]\nkind = "one-point"\n[wing]\nspan_m = 4.0\n', "mine.toml")


@pytest.mark.parametrize("plant", FORCES)
def test_a_lull_to_nothing_ends_on_the_ground_or_in_the_air_but_not_in_nonsense(plant):
    scenario = load_scenario(set_of(plant))
    for key, value in (("wind.lull_start_s", 8.0), ("wind.lull_length_s", 30.0), ("run.duration_s", 50.0)):
        scenario.set(key, value, "test")
    result = run_scenario(scenario, RunOptions(), notice=lambda _: None)
    assert result.numbers["verdict"] == "lost"
    assert "the kite crashed in" in result.numbers["trouble"]
    assert 8.0 < result.numbers["sim_s"] < 45.0
    assert all(math.isfinite(value) for row in result.flight.rows for value in row)


def test_every_set_flies_the_law_that_its_parameters_say():
    for plant in FORCES:
        scenario = load_scenario(set_of(plant))
        flown = fly_and_identify(scenario, lambda _: None)
        assert flown.numbers["verdict"] == "tracking"
        assert flown.heading.r2 > 0.95 and flown.heading.r2 > flown.course.r2
        assert scenario.parameter("TURN_K") == pytest.approx(flown.heading.k_rad_per_m, rel=0.1)


def test_a_variation_that_does_not_fly_is_told_in_its_place():
    text = variation_table("kite.depower", (0.25, 0.59), lambda _: None)
    rows = text.strip().splitlines()
    assert rows[0] == "| `kite.depower` | one-point | four-point |" and len(rows) == 4
    assert rows[2].count("R²") == 2
    assert "does not fly" in rows[3]


def test_families_are_complete():
    assert {set_of(plant) for plant in PLANTS} <= set(scenario_names())
    assert {f"paper-no-delay-{plant}" for plant in FORCES} <= set(scenario_names())


@pytest.mark.parametrize("rate_limit", [0.0, 4.0])
def test_no_step_of_the_vortex_lattice_is_longer_than_asked_for(rate_limit):
    scenario = load_scenario("small-kite-vortex-lattice")
    for key, value in (("plant.step_s", 0.0015), ("actuator.rate_limit_per_s", rate_limit)):
        scenario.set(key, value, "test")
    flight = Flight(scenario, InprocRuntime())
    system = flight.plant.system  # type: ignore[attr-defined]
    taken: list[float] = []
    step = system.step

    def note(dt, *rest):
        taken.append(dt)
        step(dt, *rest)

    system.step = note
    flight.fly(0.2)
    assert sum(taken) == pytest.approx(0.2) and max(taken) <= 0.0015 + 1e-9


@pytest.mark.parametrize("plant", FORCES)
def test_a_shorter_step_is_taken_by_every_plant_and_changes_little(plant):
    def flown(step_s):
        scenario = load_scenario(set_of(plant))
        scenario.set("plant.step_s", step_s, "test")
        flight = Flight(scenario, InprocRuntime())
        flight.fly(1.0)
        return flight.rows[-1][1:3]

    usual, shorter = flown(0.01), flown(0.001)
    assert usual != shorter and usual == pytest.approx(shorter, abs=0.005)
