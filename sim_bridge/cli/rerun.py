"""`kite-sitl rerun`: flies a logged run again, and compares it to the bit."""

import json
import math
from argparse import Namespace
from pathlib import Path
from typing import Any, NamedTuple

from sim_bridge.cli.actions import report
from sim_bridge.cli.notes import notice
from sim_bridge.errors import ScenarioError
from sim_bridge.flight.truth_columns import COLUMNS, TruthRow
from sim_bridge.runs.provenance import differences, interpreter_as_logged, scenario_as_logged
from sim_bridge.runs.reader import LoggedTruth, read_about, read_input
from sim_bridge.runs.run import RecordedGround, RunOptions, run_scenario


class _Span(NamedTuple):
    """The rows of a log that can be compared, and why there are no more."""

    rows: int
    until_s: float
    why: str | None


def rerun(options: Namespace) -> int:
    """`kite-sitl rerun`: 0 if the run came out the same to the bit."""
    folder = Path(options.folder)
    about = read_about(folder)
    if about["real_time"]:
        raise ScenarioError(f"{folder}: a real-time run, which cannot be repeated to the bit; "
                            "only lockstep runs can")
    scenario = scenario_as_logged(about, folder)
    period_s = 1.0 / scenario.parameter("LOOP_HZ")
    truth = LoggedTruth(folder)
    datagrams, known_before = read_input(folder, about)
    span = _span(folder, about, truth, known_before, period_s)
    interpreter, others = interpreter_as_logged(about, options.interpreter, folder)
    others = differences(about) + others
    for other in others:
        notice(other)
    recorded = RecordedGround(datagrams, period_s) if datagrams else None
    again = RunOptions(about["runtime"], until_s=span.until_s, interpreter=interpreter)
    result = run_scenario(scenario, again, recorded, notice=notice)
    difference = _first_difference(truth, span.rows, result.flight.rows)
    if options.json:
        print(json.dumps(result.numbers | {"same": difference is None, "difference": difference,
                                           "until_s": span.until_s, "cut": span.why, "differs": others}))
    else:
        report(result, False)
        upto = f" up to {span.until_s:.2f} s ({span.why})" if span.why else ""
        print(f"the same to the bit{upto}" if difference is None else f"NOT the same: {difference}")
        if difference and others:
            print("code, versions or defaults differ, as listed above")
    return 0 if difference is None else 1


def _span(folder: Path, about: dict[str, Any], truth: LoggedTruth, known_before: float, period_s: float) -> _Span:
    """How far the log goes.

    Raises:
        ScenarioError: it holds no tick of the flight.
    """
    why = None if about.get("complete", True) and not about.get("log_ended") else "the log ends there"
    rows = len(truth.rows)
    if truth.is_cut:
        why = "truth.csv is truncated there"
    while rows and round(truth.time_s(rows - 1) / period_s) >= known_before:
        rows -= 1
        why = "ground-station input is not recorded beyond it"
    if not rows:
        raise ScenarioError(f"{folder}: the log ends before the flight began: nothing to fly again")
    return _Span(rows, truth.time_s(rows - 1) + period_s, why)


def _first_difference(truth: LoggedTruth, count: int, flown: list[TruthRow]) -> str | None:
    """Where the flown rows first differ from the first `count` of the log, or None; a log may begin late."""
    places = [(name, COLUMNS.index(name), place) for place, name in enumerate(truth.columns) if name in COLUMNS]
    first_s = truth.time_s(0)
    begin = next((index for index, row in enumerate(flown) if row.time_s >= first_s - 1e-9), len(flown))
    for index, (row, logged) in enumerate(zip(flown[begin:], truth.rows[:count], strict=False), begin):
        for name, column, place in places:
            now, then = row[column], logged[place]
            if repr(now) != then and not _same(now, then):
                return f"tick {index}, {name}: {now!r} now, {then} logged"
    if len(flown) - begin != count:
        return f"{len(flown) - begin} ticks now, {count} logged"
    return None


def _same(now: float, then: str) -> bool:
    """The same number, however it was written."""
    return now == float(then) and math.copysign(1.0, now) == math.copysign(1.0, float(then))
