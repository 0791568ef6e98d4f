"""Simulation speed: real-time factor, time per firmware tick and per plant step."""

import platform
import time
from collections.abc import Callable
from typing import Any

from sim_bridge.flight.flight import Flight
from sim_bridge.flight.plant_choice import warm_up
from sim_bridge.runtimes.inproc import InprocRuntime
from sim_bridge.scenario.scenario import load_scenario

_FLIGHTS = 3


class _Timed:
    """A function that adds up the time spent in it."""

    def __init__(self, function: Callable[..., Any]):
        self._function = function
        self.total_s = 0.0
        self.calls = 0

    def __call__(self, *arguments: Any) -> Any:
        start = time.perf_counter()
        try:
            return self._function(*arguments)
        finally:
            self.total_s += time.perf_counter() - start
            self.calls += 1


def bench(name: str, duration_s: float, notice: Callable[[str], None]) -> dict[str, Any]:
    """Fly the scenario `name` in-process for `duration_s`, the best of several flights, then with the parts timed."""
    factors = []
    warm_up(load_scenario(name), notice)
    for _ in range(_FLIGHTS):
        flight = Flight(load_scenario(name), InprocRuntime())
        start = time.perf_counter()
        flight.fly(duration_s)
        factors.append(duration_s / (time.perf_counter() - start))
    runtime = InprocRuntime()
    flight = Flight(load_scenario(name), runtime)
    tick = _Timed(runtime.autopilot.tick)
    runtime.autopilot.tick = tick  # type: ignore[method-assign]
    step = _Timed(flight.plant.step)
    flight.plant.step = step  # type: ignore[method-assign]
    flight.fly(duration_s)
    return {
        "scenario": name, "runtime": "inproc", "sim_s": duration_s, "flights": _FLIGHTS,
        "real_time_factor": max(factors), "real_time_factor_least": min(factors),
        "firmware_tick_us": 1e6 * tick.total_s / tick.calls, "plant_step_us": 1e6 * step.total_s / step.calls,
        "python": platform.python_version(), "machine": platform.machine(),
    }
