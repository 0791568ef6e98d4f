"""Flights in real time with every timing at its default, judged by where the kite really was."""

import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from protocol import dialect
from sim_bridge.flight.truth_columns import COLUMNS
from sim_bridge.runs.hardware_in_the_loop import fly_board
from sim_bridge.runs.run import RunOptions, run_scenario
from sim_bridge.scenario.scenario import Scenario, load_scenario
from tests.sim_bridge.test_hil import BAUD, Cable, firmware_on
from tests.sim_bridge.test_preflight import modes_flown

pytestmark = pytest.mark.soak

FLIGHT_S = 60.0


@pytest.fixture
def cable(tmp_path: Path) -> Iterator[Cable]:
    cable = Cable(tmp_path)
    yield cable
    cable.close()


def scenario_of(name: str) -> Scenario:
    scenario = load_scenario(name)
    scenario.set("run.duration_s", FLIGHT_S, "test")
    return scenario


@pytest.mark.parametrize("runtime", ["cpython", "micropython"])
@pytest.mark.parametrize("name", ["paper-delay-tuned", "small-kite", "v3-flight", "small-kite-one-point"])
def test_a_minute_in_real_time_is_flown_as_in_lockstep(name, runtime):
    """Within half as much again as in lockstep, and 1 deg for the two clocks that run side by side."""
    lockstep = run_scenario(scenario_of(name), RunOptions()).numbers
    result = run_scenario(scenario_of(name), RunOptions(runtime, speed=1))
    assert result.numbers["verdict"] == "tracking", result.numbers["trouble"]
    assert modes_flown(result.flight) == {dialect.KITE_MODE_TRACK}
    assert result.numbers["cross_track_rms_rad"] < 1.5 * lockstep["cross_track_rms_rad"] + 0.0175
    assert FLIGHT_S - 0.1 <= result.numbers["wall_s"] < FLIGHT_S + 1.0


@pytest.mark.parametrize("delay_s", [0.05, 0.2])
def test_a_board_on_a_cable_flies_the_delay_that_was_asked_for(cable, delay_s):
    scenario = scenario_of("paper-delay-tuned")
    scenario.set("link.control.delay_s", delay_s, "test")
    board: subprocess.Popen[bytes] = firmware_on(str(cable.ends[1]), "micropython")
    said: list[str] = []
    try:
        result, measured = fly_board(scenario, f"serial:{cable.ends[0]}:{BAUD}", RunOptions("hil", 1.0), said.append)
    finally:
        board.kill()
        board.wait()
    assert result.numbers["verdict"] == "tracking" and not said
    assert {row[COLUMNS.index("mode")] for row in result.flight.rows} == {dialect.KITE_MODE_TRACK}
    assert measured["delay_flown_s"] == pytest.approx(delay_s, abs=0.003)
