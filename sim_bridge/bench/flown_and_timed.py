# Flies scenarios and times them: one process, started by loops.py, for each loop that is compared.
# Argument: "compiled", or "interpreted". Reads lines of "scenario seconds", answers each with a line of JSON.
# It is handed to the interpreter as text, so that it also runs in a checkout of another version.

import json
import sys
import time


def use_loop(wanted):
    """Choose the loop, where there is a choice; return the one in use, and what kept it from being the one wanted."""
    try:
        from sim_bridge.native.choice import choose_loop, loop_in_use
    except ImportError:
        return "interpreted", None
    problem = choose_loop(wanted == "interpreted")
    return loop_in_use(), problem


LOOP, PROBLEM = use_loop(sys.argv[1])

try:
    from sim_bridge.flight.flight import Flight
    from sim_bridge.scenario.scenario import load_scenario
except ImportError:  # before these had folders
    from sim_bridge.flight import Flight
    from sim_bridge.scenario import load_scenario
from sim_bridge.runtimes.inproc import InprocRuntime


class Timed:
    """Stands in for a runtime or a plant, and adds up the time spent in one of its functions."""

    def __init__(self, part, name):
        self._part = part
        self._function = getattr(part, name)
        self.total_s = 0.0
        self.calls = 0
        setattr(self, name, self._timed)

    def __getattr__(self, name):
        return getattr(self._part, name)

    def _timed(self, *arguments):
        start = time.perf_counter()
        result = self._function(*arguments)
        self.total_s += time.perf_counter() - start
        self.calls += 1
        return result


def fly(name, seconds):
    """Fly a scenario, and return the wall time that it took [s]."""
    flight = Flight(load_scenario(name), InprocRuntime())
    start = time.perf_counter()
    flight.fly(seconds)
    return time.perf_counter() - start


def time_parts(name, seconds):
    """Mean time [us] of a tick of the firmware with its runtime, and of a step of the plant."""
    runtime = Timed(InprocRuntime(), "exchange")
    flight = Flight(load_scenario(name), runtime)
    plant = Timed(flight.plant, "step")
    flight.plant = plant
    flight.fly(seconds)
    return {part: 1e6 * timed.total_s / timed.calls for part, timed in (("tick_us", runtime), ("step_us", plant))}


def answer(line):
    """What to do for a line that came."""
    what, name, seconds = line.split()
    if what == "parts":
        return time_parts(name, float(seconds))
    return {"wall_s": fly(name, float(seconds))}


print(json.dumps({"loop": LOOP, "problem": PROBLEM}), flush=True)
for asked in sys.stdin:
    print(json.dumps(answer(asked)), flush=True)
