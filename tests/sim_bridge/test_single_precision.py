"""The firmware in single precision, as boards compute: the paper's verdicts hold, and so does the tracking.

Samples, parameters and the results of all mathematical functions become numpy's float32, which keeps every sum and
product of them in single precision too; what is stored is rounded on top of that.
"""

import math

import numpy as np
import pytest

from firmware_py import estimator, guidance, sphere, steering, target_curve
from firmware_py.parameters import Parameters
from sim_bridge.run import RunOptions, run_scenario
from sim_bridge.runtimes import inproc
from sim_bridge.scenario import load_scenario

MODULES = (estimator, guidance, sphere, steering, target_curve)
CLASSES = (
    estimator.Estimator, estimator.EstimatorConfig, guidance.Guidance, guidance.GuidanceConfig, sphere.TangentFrame,
    steering.Steering, steering.SteeringConfig, target_curve.FigureEight, target_curve.CurveCheck)
FUNCTIONS = ("atan", "atan2", "cos", "degrees", "radians", "sin", "sqrt", "tan")


def rounded(function):
    return lambda *arguments: np.float32(function(*arguments))


def store_rounded(self, name, value):
    object.__setattr__(self, name, np.float32(value) if isinstance(value, float) else value)


@pytest.fixture
def single_precision(monkeypatch):
    on_the_wire, start, put = inproc.as_on_the_wire, Parameters.__init__, Parameters.set

    def singles(message, values):
        return tuple(np.float32(v) if isinstance(v, float) else v for v in on_the_wire(message, values))

    def start_single(self):
        start(self)
        self.values[:] = [np.float32(value) for value in self.values]

    monkeypatch.setattr(inproc, "as_on_the_wire", singles)
    monkeypatch.setattr(Parameters, "__init__", start_single)
    monkeypatch.setattr(Parameters, "set", lambda self, index, value: put(self, index, np.float32(value)))
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
