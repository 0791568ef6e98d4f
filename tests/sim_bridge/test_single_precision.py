"""The firmware in single precision, as boards compute: the verdicts hold, and so does the tracking.

In this process: samples, parameters and the results of all mathematical functions become numpy's float32, which keeps
every sum and product of them in single precision too; what is stored is rounded on top of that. And every scenario
under a MicroPython built with single-precision floats, where there is one.
"""

import math
import os

import numpy as np
import pytest

from firmware_py import sphere
from firmware_py.control import figure_eight, gains, guidance, steering
from firmware_py.estimation import estimator, turn_k_estimate
from firmware_py.parameters.values import Parameters
from firmware_py.prediction import body_rotation, drift, prediction, steering_history
from sim_bridge.equipment import sensors
from sim_bridge.runs.run import RunOptions, run_scenario
from sim_bridge.runtimes import inproc
from sim_bridge.runtimes.interpreter import find_interpreter
from sim_bridge.scenario.scenario import load_scenario, scenario_names

MODULES = (
    estimator, guidance, sphere, steering, figure_eight, prediction, drift, body_rotation, steering_history,
    turn_k_estimate, gains)
CLASSES = (
    estimator.Estimator, estimator.EstimatorConfig, guidance.Guidance, guidance.GuidanceConfig, sphere.TangentFrame,
    steering.Steering, steering.SteeringConfig, figure_eight.FigureEight, figure_eight.CurveCheck,
    prediction.Prediction, prediction.PredictionConfig, drift.Drift, body_rotation.BodyRotation,
    steering_history.SteeringHistory, turn_k_estimate.TurnKEstimate, gains.Gains)
FUNCTIONS = ("atan", "atan2", "cos", "degrees", "radians", "sin", "sqrt", "tan")


def rounded(function):
    return lambda *arguments: np.float32(function(*arguments))


def store_rounded(self, name, value):
    object.__setattr__(self, name, np.float32(value) if isinstance(value, float) else value)


@pytest.fixture
def single_precision(monkeypatch):
    on_the_wire, start, put = inproc.as_on_the_wire, Parameters.__init__, Parameters.set
    float32 = sensors.float32

    def singles(message, values):
        return tuple(np.float32(v) if isinstance(v, float) else v for v in on_the_wire(message, values))

    def start_single(self):
        start(self)
        self.values[:] = [np.float32(value) for value in self.values]

    monkeypatch.setattr(inproc, "as_on_the_wire", singles)
    monkeypatch.setattr(sensors, "float32", lambda value: np.float32(float32(value)))
    monkeypatch.setattr(Parameters, "__init__", start_single)
    monkeypatch.setattr(
        Parameters, "set", lambda self, index, value: put(self, index, np.float32(value)))  # type: ignore[arg-type]
    for module in MODULES:
        for name in FUNCTIONS:
            if hasattr(module, name):
                monkeypatch.setattr(module, name, rounded(getattr(math, name)))
    for class_ in CLASSES:
        monkeypatch.setattr(class_, "__setattr__", store_rounded, raising=False)


def fly(name):
    return run_scenario(load_scenario(name), RunOptions())


@pytest.fixture(scope="module")
def double_precision():
    return {name: fly(name).numbers for name in ("paper-no-delay", "paper-delay", "paper-delay-tuned")}


@pytest.mark.parametrize("name", ["paper-no-delay", "paper-delay", "paper-delay-tuned"])
def test_verdict_and_tracking_survive_single_precision(name, double_precision, single_precision):
    result = fly(name)
    assert isinstance(result.flight.runtime, inproc.InprocRuntime)
    autopilot = result.flight.runtime.autopilot
    values = (autopilot.guidance.target_course, autopilot.steering.asked, autopilot.kite.frame.e1x)
    assert {type(value).__name__ for value in values} == {"float32"}  # or this would prove nothing
    assert result.numbers["verdict"] == double_precision[name]["verdict"]
    if name != "paper-delay":
        assert result.numbers["cross_track_rms_rad"] == pytest.approx(
            double_precision[name]["cross_track_rms_rad"], rel=0.02)
        assert result.numbers["cross_track_rms_rad"] != double_precision[name]["cross_track_rms_rad"]


@pytest.mark.parametrize("name", ["small-kite", "v3-flight"])
def test_prediction_survives_single_precision(name, single_precision):
    """No cancellation on the way: what it takes out of the error is left to within what gusts make of it."""
    scenario = load_scenario(name)
    scenario.set("wind.turbulence_intensity", 0.0, "test")
    scenario.set_parameter("K_ADAPT", 1.0, "test")
    scenario.set_parameter("TURN_K", 1.25 * scenario.values["plant.turn_k"], "test")
    result = run_scenario(scenario, RunOptions())
    assert isinstance(result.flight.runtime, inproc.InprocRuntime)
    autopilot = result.flight.runtime.autopilot
    values = (autopilot.prediction.course, autopilot.prediction.frame.e1x, autopilot.turn_k.value)
    assert {type(value).__name__ for value in values} == {"float32"}
    assert result.numbers["cross_track_rms_rad"] < 0.003
    assert autopilot.turn_k.value == pytest.approx(scenario.values["plant.turn_k"], rel=0.01)


@pytest.fixture(scope="module")
def micropython_f32() -> str:
    """Path of a MicroPython with single-precision floats; a wrong one is an error, none skips."""
    path = os.environ.get("MICROPYTHON_F32")
    if not path:
        pytest.skip("no MicroPython in single precision: set MICROPYTHON_F32 to one, built as docs/boards.md shows")
    assert find_interpreter(path).float_bits == 32, f"MICROPYTHON_F32={path}: {find_interpreter(path)}"
    return path


@pytest.mark.parametrize("name", scenario_names())
def test_every_scenario_flies_as_well_under_micropython_in_single_precision(name, micropython_f32):
    """In lockstep and at full length. Where the flight is unstable, rounding decides where it goes, so only how it is
    judged is compared. Gusts amplify rounding; without them less is left of it than a clock kept as a float would make.
    """
    double = fly(name).numbers
    scenario = load_scenario(name)
    single = run_scenario(scenario, RunOptions("micropython", interpreter=micropython_f32)).numbers
    assert (single["verdict"], single["trouble"]) == (double["verdict"], double["trouble"])
    assert (single["ticks"], single["overruns"]) == (double["ticks"], double["overruns"])
    error, exact = single["cross_track_rms_rad"], double["cross_track_rms_rad"]
    assert error != exact  # or this was double precision
    if double["verdict"] == "tracking":
        assert error == pytest.approx(exact, rel=0.01 if scenario.wind.turbulence_intensity else 0.0002)
