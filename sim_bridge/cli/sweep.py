"""The verb `kite-sitl sweep`."""

import json
from argparse import Namespace
from pathlib import Path
from typing import Any

from tqdm import tqdm

from kite_analysis.verdicts import VERDICTS
from sim_bridge.cli.notes import notice
from sim_bridge.cli.plot_option import plot_path, save_plot
from sim_bridge.cli.scenario_options import scenario_of
from sim_bridge.flight.plant_choice import slowness
from sim_bridge.runs.provenance import wind_fingerprint
from sim_bridge.scenario.scenario import Scenario
from sim_bridge.sweeps.axes import Axis, apply, grid, parse_axis, random_sample
from sim_bridge.sweeps.execute import fly_all, make_executor
from sim_bridge.sweeps.map_plot import draw_map
from sim_bridge.sweeps.results import Results

_VERDICTS = (*VERDICTS, "refused")


def sweep_command(options: Namespace) -> int:
    """`kite-sitl sweep`: 0 when all runs have been flown, 130 after Ctrl-C."""
    base = scenario_of(options, notice)
    axes = [parse_axis(text) for text in options.over]
    if slow := slowness(base.plant_kind):
        notice(slow)
    out = Path(options.out or f"{base.name}-sweep.csv")
    options.force |= out.exists()  # a sweep that goes on draws its own map again
    plot = plot_path(options, out.with_suffix(".png"))
    points = random_sample(axes, options.runs, base.run.seed) if options.runs else grid(axes)
    scenarios = [_scenario_of_run(base, axes, values, run) for run, values in enumerate(points)]
    winds = sorted({scenario.wind.file for scenario in scenarios} - {""})
    plan = {"scenario": base.to_dict(), "over": options.over, "runs": options.runs or 0,
            "wind": {path: wind_fingerprint(path) for path in winds}}
    results = Results(out, plan, [axis.key for axis in axes], options.other_code)
    try:
        interrupted = _fly(options, axes, points, scenarios, results)
    finally:
        results.close()
    if plot and results.rows:
        save_plot(draw_map(base, axes, list(results.rows.values())), plot)
    _report(options, len(points), results, plot if results.rows else None)
    return 130 if interrupted else 0


def _scenario_of_run(base: Scenario, axes: list[Axis], values: tuple[str, ...], run: int) -> Scenario:
    scenario = Scenario.from_dict(base.to_dict(), base.name)
    scenario.set("run.seed", base.run.seed + run, "--seed")
    apply(scenario, axes, values)
    return scenario


def _fly(options: Namespace, axes: list[Axis], points: list[tuple[str, ...]], scenarios: list[Scenario],
         results: Results) -> bool:
    """Fly what is not there yet; True after Ctrl-C."""
    missing = [run for run in range(len(points)) if run not in results.rows]
    if len(missing) < len(points):
        other = f", {results.flown_by_other_code} of them by other code" if results.flown_by_other_code else ""
        notice(f"{len(points) - len(missing)} of {len(points)} runs exist already{other}")
    try:
        with make_executor(options.jobs, options.scheduler) as (executor, workers), \
                tqdm(total=len(points), initial=len(points) - len(missing), unit="run",
                     disable=None if not options.json else True) as bar:
            def take(row: dict[str, Any]) -> None:
                values = points[row["run"]]
                results.add(row | {axis.key: value for axis, value in zip(axes, values, strict=True)})
                bar.update()

            fly_all(executor, workers, [(run, scenarios[run].to_dict()) for run in missing], options.interpreted, take)
    except KeyboardInterrupt:
        notice(f"stopped after {len(results.rows)} of {len(points)} runs; the same command resumes")
        return True
    return False


def _report(options: Namespace, runs: int, results: Results, plot: Path | None) -> None:
    verdicts = [row["verdict"] for row in results.rows.values()]
    counts = {name: verdicts.count(name) for name in _VERDICTS if name in verdicts}
    if options.json:
        print(json.dumps({"runs": runs, "flown": len(verdicts), "verdicts": counts, "results": str(results.path),
                          "plot": str(plot) if plot else None}))
        return
    print(f"{len(verdicts)} of {runs} runs: " + ", ".join(f"{count} {name}" for name, count in counts.items()))
    print(f"results: {results.path}" + (f"\nplot: {plot}" if plot else ""))
