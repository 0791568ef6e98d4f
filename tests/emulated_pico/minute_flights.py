"""A minute of each of three scenarios on an emulated Pico, at two clocks: the table of docs/boards.md.

    PICO_IMAGE=RPI_PICO-v1.28.0.uf2 python -m tests.emulated_pico.minute_flights [--seconds 60] [--jobs 2]
"""

import argparse
import re
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path

from sim_bridge.boards.image import lay_out
from sim_bridge.errors import FirmwareError
from sim_bridge.runs.run import RunOptions, run_scenario
from sim_bridge.scenario.scenario import Scenario, load_scenario
from tests.emulated_pico.flight import ON_A_CABLE, START_S, fly
from tests.emulated_pico.pico import EmulatedPico, why_missing

SCENARIOS = ("small-kite", "v3-flight", "paper-delay-tuned")
CLOCKS_MHZ = (200, 125)
_QUANTITIES = (
    "", "clock", "tick: median", "99.9 %", "worst", "latest start", "ticks lost", "garbage collected", "longest pause",
    "heap live / free", "stack", "sample to steering", "cross-track", "of CPython's")
_ASK_HEAP = "import gc; gc.collect(); print('heap', gc.mem_alloc(), gc.mem_free())\r\n"


def minute(name: str, clock_mhz: int, seconds: float) -> tuple[str, ...]:
    """A column of the table."""
    from tests.emulated_pico.filesystem import filesystem_of  # noqa: PLC0415  an extra's

    with tempfile.TemporaryDirectory() as folder:
        lay_out(Path(folder), ON_A_CABLE | {"CPU_MHZ": clock_mhz}, "armv6m")
        pico = EmulatedPico(filesystem_of(Path(folder)))
    try:
        pico.run_until_printed("running as system", START_S)
        pico.run(0.5)
        result, kept = fly(pico, _scenario(name, seconds))
        live, free = _heap(pico)
    except FirmwareError as error:
        return (name, f"{clock_mhz} MHz", str(error), *[""] * (len(_QUANTITIES) - 3))
    finally:
        pico.close()
    reference = _scenario(name, seconds)  # with the delay that was flown, where the board's own is the longer one
    if 1e-3 * kept.delay > result.flight.delay_asked_s:
        reference.set_text(f"link.control.delay_s={1e-3 * kept.delay:.4f}", "--set")
    here = run_scenario(reference, RunOptions()).numbers["cross_track_rms_rad"]
    there = result.numbers["cross_track_rms_rad"]
    return (
        name, f"{clock_mhz} MHz", f"{kept.median:.1f} ms", f"{kept.p999:.1f} ms", f"{kept.worst:.1f} ms",
        f"{kept.latest:.1f} ms", f"{kept.lost}", f"{kept.collections} times, {kept.in_ticks} in a tick",
        f"{kept.longest_collection:.1f} ms", f"{live / 1000:.0f} / {free / 1000:.0f} KB", f"{kept.stack_bytes} bytes",
        f"{kept.delay:.1f} ms",
        f"{there:.5f} rad", f"{there / here:.2f}")


def _scenario(name: str, seconds: float) -> Scenario:
    scenario = load_scenario(name)
    scenario.set_text(f"run.duration_s={seconds:g}", "--set")
    return scenario


def _heap(pico: EmulatedPico) -> tuple[int, int]:
    """Bytes of the heap that are live and free, asked at the console after Ctrl-C."""
    pico.type("\x03")
    pico.run(0.5)
    pico.type(_ASK_HEAP)
    pico.run(0.5)
    live, free = re.findall(r"heap (\d+) (\d+)", pico.printed())[-1]
    return int(live), int(free)


def main() -> int:
    """Print the table, and before it, on stderr, each flight that has ended."""
    parser = argparse.ArgumentParser(description="A minute of flight on an emulated Pico.")
    parser.add_argument("--seconds", type=float, default=60.0, help="length of each flight (default: %(default)g)")
    parser.add_argument("--jobs", type=int, default=2, help="flights at a time (default: %(default)d)")
    options = parser.parse_args()
    if problem := why_missing():
        print(f"no emulated Pico: {problem}", file=sys.stderr)
        return 1
    clocks, names = zip(*product(CLOCKS_MHZ, SCENARIOS), strict=True)
    columns: list[tuple[str, ...]] = [_QUANTITIES]
    with ProcessPoolExecutor(options.jobs) as pool:
        for column in pool.map(minute, names, clocks, [options.seconds] * len(names)):
            print(", ".join(column), file=sys.stderr, flush=True)
            columns.append(column)
    rows = [f"| {' | '.join(row)} |" for row in zip(*columns, strict=True)]
    print("\n".join([rows[0], f"|{'---|' * len(columns)}", *rows[1:]]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
