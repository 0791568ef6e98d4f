"""The verb `kite-sitl bench`."""

import json
from argparse import Namespace
from pathlib import Path

from kite_analysis.picture_file import check_new_file
from sim_bridge.bench.loops import LEAST_RUNS, SCENARIOS, compare_loops
from sim_bridge.bench.micropython import bench_micropython
from sim_bridge.bench.speed_page import as_json, lines, page
from sim_bridge.cli.notes import notice
from sim_bridge.errors import ScenarioError
from sim_bridge.runs.run_choices import ONLY_MICROPYTHON
from sim_bridge.scenario.scenario import load_scenario


def bench(options: Namespace) -> int:
    """`kite-sitl bench`."""
    if options.runtime == "micropython":
        return _bench_micropython(options)
    if options.interpreter:
        raise ScenarioError(ONLY_MICROPYTHON)
    if options.runs < LEAST_RUNS:
        raise ScenarioError(f"--runs {options.runs}: fewer than {LEAST_RUNS} flights say little")
    out = Path(options.out) if options.out else None
    if out:
        check_new_file(out, options.force)
    names = [options.scenario] if options.scenario else list(SCENARIOS)
    for name in names:
        load_scenario(name)  # a mistake is found before anything is measured
    before = Path(options.before) if options.before else None
    compared = compare_loops(names, options.duration or 60.0, options.runs, before, notice)
    if out:
        try:
            out.write_text(page(compared, options.duration or 60.0, options.runs), "utf-8")
        except OSError as error:
            raise ScenarioError(f"--out {out}: {error.strerror}") from error
        notice(f"page: {out}")
    print(json.dumps(as_json(compared)) if options.json else "\n".join(lines(compared)))
    return 0


def _bench_micropython(options: Namespace) -> int:
    numbers = bench_micropython(load_scenario(options.scenario or "small-kite"), options.duration or 600.0,
                                options.interpreter)
    if options.json:
        print(json.dumps(numbers))
        return 0
    print(f"{numbers['scenario']} under MicroPython, {numbers['ticks']} ticks in flight with telemetry:")
    half = " (half on a board)" if numbers["word_bytes"] == 8 else ""
    print(f"  a tick: {numbers['bytes_per_tick']:.0f} bytes, {numbers['bytes_per_tick_worst']} worst{half}; "
          f"{numbers['us_per_tick']:.0f} us, {numbers['us_per_tick_worst']} worst, on this machine")
    print(f"  at most {numbers['float_results_worst_at_most']:.0f} float results (docs/boards.md: a tick on a board)")
    print(f"  heap: {numbers['free_after_import']} bytes free after import; {numbers['free_lost_bytes']} lost flying")
    print(f"  collector: {numbers['collector_pause_worst_us']} us worst, on this machine; "
          f"firmware as .mpy: {numbers['mpy_bytes']} bytes")
    return 0
