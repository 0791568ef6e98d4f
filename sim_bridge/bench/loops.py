"""How fast scenarios are flown in one process: compiled, interpreted, and by another checkout, side by side.

Each loop has a process of its own. They fly in turn, so that a machine that is now fast and now slow is so to all of
them; a ratio is the median of those of the single rounds.
"""

import json
import platform
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

from sim_bridge.errors import ScenarioError
from sim_bridge.native.choice import COMPILED, INTERPRETED
from sim_bridge.native.modules import ROOT

BEFORE = "before"
SCENARIOS = ("small-kite", "v3-flight", "paper-delay-tuned", "small-kite-one-point", "small-kite-four-point",
             "small-kite-vortex-lattice")
LEAST_RUNS = 5
_PARTS_S = 10.0  # flown with the parts timed
_FLYER = Path(__file__).parent / "flown_and_timed.py"


class Speed(NamedTuple):
    """Times real time of a loop in a scenario, over some flights; a tick with its runtime, and a plant's step [us]."""

    median: float
    least: float
    most: float
    tick_us: float
    step_us: float


class Comparison(NamedTuple):
    """A scenario's speeds by loop, and their ratios to each of the others: (loop, other) to how much faster it is."""

    scenario: str
    speeds: dict[str, Speed]
    ratios: dict[tuple[str, str], float]


class _Flyer:
    """A process that flies with one loop."""

    def __init__(self, loop: str, python: str = sys.executable, folder: Path = ROOT):
        self._process = subprocess.Popen(
            [python, "-c", _FLYER.read_text("utf-8"), COMPILED if loop == COMPILED else INTERPRETED], cwd=folder,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self._folder = folder
        started = self._read()
        self.problem = started["problem"]
        self.loop = started["loop"]

    def fly(self, scenario: str, seconds: float) -> float:
        """Wall time of a flight [s]."""
        return self._ask(f"flight {scenario} {seconds}")["wall_s"]

    def time_parts(self, scenario: str) -> dict[str, float]:
        """Mean times [us] of a tick with its runtime, and of a step of the plant."""
        return self._ask(f"parts {scenario} {_PARTS_S}")

    def stop(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()

    def _ask(self, line: str) -> dict[str, Any]:
        assert self._process.stdin is not None
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()
        return self._read()

    def _read(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            _, said = self._process.communicate()
            *_, last = ["nothing said", *said.strip().splitlines()]
            raise ScenarioError(f"{self._folder}: its process ended: {last}")
        return json.loads(line)


def compare_loops(scenarios: Sequence[str], duration_s: float, runs: int, before: Path | None,
                  notice: Callable[[str], None]) -> list[Comparison]:
    """Fly each of `scenarios` `runs` times for `duration_s` with each loop that there is.

    `before` is another checkout with an environment of its own (.venv), whose loop is compared, too.

    Raises:
        ScenarioError: it has none, or a process failed.
    """
    flyers: dict[str, _Flyer] = {}
    try:
        compiled = _Flyer(COMPILED)
        if compiled.loop == COMPILED:
            flyers[COMPILED] = compiled
        else:
            compiled.stop()
            notice(compiled.problem or "there is no compiled loop to compare with: `make compiled` builds it")
        flyers[INTERPRETED] = _Flyer(INTERPRETED)
        if before is not None:
            python = before / ".venv" / "bin" / "python"
            if not python.exists():
                raise ScenarioError(f"--before {before}: no {python.relative_to(before)} there: install it first")
            flyers[BEFORE] = _Flyer(BEFORE, str(python), before)
        return [_compare(name, flyers, duration_s, runs, notice) for name in scenarios]
    finally:
        for flyer in flyers.values():
            flyer.stop()


def machine() -> str:
    """The machine and the Python, for a table's head."""
    return f"{platform.machine()}, {platform.system()}, CPython {platform.python_version()}"


def _compare(scenario: str, flyers: dict[str, _Flyer], duration_s: float, runs: int, notice: Callable[[str], None]
             ) -> Comparison:
    notice(f"{scenario}: {runs} flights of {duration_s:g} s each, {', '.join(flyers)}")
    for flyer in flyers.values():
        flyer.fly(scenario, min(duration_s, 5.0))  # warm
    walls = {loop: [] for loop in flyers}
    for _ in range(runs):
        for loop, flyer in flyers.items():
            walls[loop].append(flyer.fly(scenario, duration_s))
    speeds = {}
    for loop, flyer in flyers.items():
        factors = [duration_s / wall_s for wall_s in walls[loop]]
        speeds[loop] = Speed(median(factors), min(factors), max(factors), **flyer.time_parts(scenario))
    ratios = {(loop, other): median(theirs / ours for ours, theirs in zip(walls[loop], walls[other], strict=True))
              for loop in flyers for other in flyers if loop != other}
    return Comparison(scenario, speeds, ratios)
