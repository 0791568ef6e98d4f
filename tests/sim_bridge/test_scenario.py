"""Scenario files: what ships is sound, and what is wrong is said in one line."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.parameter_table import load_parameters
from sim_bridge.errors import ScenarioError
from sim_bridge.scenario.keys import KEYS
from sim_bridge.scenario.scenario import Scenario, load_scenario, parse_scenario, scenario_names


@pytest.mark.parametrize("name", scenario_names())
def test_what_ships_can_be_read_and_survives_a_log(name):
    scenario = load_scenario(name)
    assert scenario.title
    again = Scenario.from_dict(json.loads(json.dumps(scenario.to_dict())), "log")
    assert again.values == scenario.values and again.parameters == scenario.parameters


def test_every_default_is_within_its_own_bounds():
    scenario = Scenario("test")
    for key, entry in KEYS.items():
        if entry.default is not None:
            scenario.set(key, entry.default, "test")
    assert scenario.values == Scenario("test").values


@pytest.mark.parametrize(("text", "says"), [
    ("[plant", "broken TOML"),
    ("[plant]\nturn_kk = 1", "no key plant.turn_kk; did you mean plant.turn_k?"),
    ("[plant]\nturn_k = 'x'", "plant.turn_k takes a number"),
    ("[plant]\nturn_k = true", "plant.turn_k takes a number"),
    ("[plant]\nkind = 'balloon'", "plant.kind is one of"),
    ("[link.control]\nloss = 1.5", "link.control.loss = 1.5 is outside 0 to 1"),
    ("[link.control]\nloss = nan", "link.control.loss = nan is outside"),
    ("[run]\nseed = 1.5", "run.seed takes a whole number"),
    ("[parameters]\nINNERP = 1", "no parameter INNERP; did you mean INNER_P?"),
    ("[parameters]\nINNER_P = 51", "INNER_P = 51 is outside 0.0625 to 50 1/s"),
    ("[parameters]\nTABLE_VERSION = 1", "TABLE_VERSION is read-only"),
    ("parameters = 3", "parameters is a section"),
])
def test_what_is_wrong_is_said_in_one_line_with_the_place(text, says):
    with pytest.raises(ScenarioError) as error:
        parse_scenario("mine", text, "mine.toml")
    assert says in str(error.value) and str(error.value).startswith("mine.toml: ")
    assert "\n" not in str(error.value)


@given(st.sampled_from(list(load_parameters().values())), st.floats(allow_nan=True, allow_infinity=True))
def test_a_parameter_is_taken_as_the_table_says_or_refused(parameter, value):
    scenario = Scenario("test")
    if parameter.read_only or parameter.problem_with(value):
        with pytest.raises(ScenarioError):
            scenario.set_parameter(parameter.name, value, "test")
        assert not scenario.parameters
    else:
        scenario.set_parameter(parameter.name, value, "test")
        taken = scenario.parameter(parameter.name)
        assert parameter.least <= taken <= parameter.greatest or (parameter.off_at_zero and taken == 0.0)
