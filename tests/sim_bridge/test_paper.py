"""The paper's runs: verdicts and numbers, on every runtime alike."""

import math
from typing import Any

import numpy as np
import pytest

from firmware_py.control.figure_eight import FigureEight
from firmware_py.control.guidance import Guidance
from kite_analysis.delay.inner_loop import loop_delay, stability_limit
from sim_bridge.flight.flight import Flight
from sim_bridge.flight.truth_columns import COLUMNS
from sim_bridge.runs.run import RunOptions, run_scenario
from sim_bridge.runtimes.inproc import InprocRuntime
from sim_bridge.runtimes.interpreter import micropython_command
from sim_bridge.scenario.plant_names import PLANTS
from sim_bridge.scenario.scenario import load_scenario
from sim_bridge.studies.paper import paper_flights

PAPER = ("paper-no-delay", "paper-delay", "paper-delay-tuned")


def fly(name, runtime="inproc", **changes: Any):
    scenario = load_scenario(name)
    for key, value in changes.items():
        scenario.set(key.replace("__", "."), value, "test")
    return run_scenario(scenario, RunOptions(runtime))


def test_without_delay_the_target_is_tracked_for_all_practical_purposes_perfectly():
    numbers = fly("paper-no-delay").numbers
    assert numbers["verdict"] == "tracking"
    assert numbers["cross_track_rms_rad"] < 0.020


def test_with_delay_the_same_gain_is_unstable():
    numbers = fly("paper-delay").numbers
    assert numbers["verdict"] == "unstable"
    assert numbers["turning_angle_rms_rad"] > 1.2


def test_the_tuned_gain_tracks_and_tracking_suffers_somewhat():
    numbers = fly("paper-delay-tuned").numbers
    assert numbers["verdict"] == "tracking"
    assert 0.04 < numbers["cross_track_rms_rad"] < 0.10


@pytest.mark.parametrize("runtime", ["cpython", "micropython"])
@pytest.mark.parametrize("name", [*PAPER, "small-kite", "v3-flight"])
def test_every_runtime_gives_the_same_numbers_to_the_bit(name, runtime):
    if runtime == "micropython" and not micropython_command():
        pytest.skip("no MicroPython interpreter on this platform")
    here, there = (fly(name, r, run__duration_s=25.0).flight for r in ("inproc", runtime))
    for tick, (ours, theirs) in enumerate(zip(here.rows, there.rows, strict=True)):
        differing = [c for c, a, b in zip(COLUMNS, ours, theirs, strict=True) if float(a).hex() != float(b).hex()]
        assert not differing, f"first difference in tick {tick}: {differing}"


@pytest.mark.parametrize("plant", PLANTS)
def test_the_three_verdicts_hold_on_every_plant(plant):
    numbers = [run_scenario(flight.scenario, RunOptions()).numbers for flight in paper_flights(plant)]
    assert [flight["verdict"] for flight in numbers] == ["tracking", "unstable", "tracking"]
    assert [flight["trouble"] for flight in numbers] == [None] * 3
    no_delay, _, tuned = (flight["cross_track_rms_rad"] for flight in numbers)
    assert no_delay < 0.02
    assert 3.0 * no_delay < tuned < 0.09


def test_one_seed_repeats_to_the_bit_and_another_does_not():
    noisy: dict[str, Any] = {"link__control__jitter_s": 0.02, "link__control__loss": 0.1, "sensors__noise_rad": 0.001,
             "wind__turbulence_intensity": 0.1, "run__duration_s": 12.0}
    first, again = (fly("small-kite", **noisy).flight.rows for _ in range(2))
    assert first == again
    assert fly("small-kite", run__seed=2, **noisy).flight.rows != first


@pytest.mark.parametrize("name", ["paper-delay-tuned", "small-kite", "v3-flight"])
def test_halving_the_step_of_the_plant_changes_cross_track_by_less_than_one_percent(name):
    step = load_scenario(name).plant.step_s
    coarse, fine = (
        fly(name, plant__step_s=s, wind__turbulence_intensity=0.0).numbers["cross_track_rms_rad"]
        for s in (step, step / 2))
    assert fine == pytest.approx(coarse, rel=0.01)


class FixedTarget(Guidance):
    """An outer loop that wants one turning angle [rad], come what may."""

    def __init__(self, course):
        super().__init__(FigureEight())
        self.target_course = course

    def scan(self, frame, course):
        """There is no curve to look at."""

    def step(self, frame, gains, dt):
        """There is nothing to update."""


def growth(gain, delay_s):
    """Late over early RMS of a small turning-angle error: the inner loop alone, on a target held fixed."""
    scenario = load_scenario("paper-delay")
    for key, value in (
        ("link.control.delay_s", delay_s), ("plant.speed_over_length", 1e-3), ("plant.transport", False),
        ("start.course_error_rad", 0.001),
    ):
        scenario.set(key, value, "test")
    scenario.set_parameter("INNER_P", gain, "test")
    scenario.set_parameter("SPEED_MIN", 0.0, "test")
    runtime = InprocRuntime()
    flight = Flight(scenario, runtime)
    target = float(flight.eight.course(np.zeros(1))[0])
    runtime.autopilot.guidance = FixedTarget(target)
    flight.fly(20.0)
    errors = [row[COLUMNS.index("course_rad")] - target for row in flight.rows]

    def rms(start_s, end_s):
        part = errors[round(start_s * 50) : round(end_s * 50)]
        return math.sqrt(math.fsum(e * e for e in part) / len(part))

    return rms(14, 19) / rms(4, 9)


@pytest.mark.parametrize("delay_s", [0.1, 0.2, 0.4])
def test_the_inner_loop_turns_unstable_where_the_theory_says(delay_s):
    predicted = stability_limit(loop_delay(delay_s, 50.0))
    low, high = 0.8 * predicted, 1.2 * predicted
    assert growth(low, delay_s) < 1.0 < growth(high, delay_s)
    while high - low > 0.005 * predicted:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if growth(middle, delay_s) < 1.0 else (low, middle)
    assert 0.5 * (low + high) == pytest.approx(predicted, rel=0.03)
