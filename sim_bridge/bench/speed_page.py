"""Speeds side by side: as a table for the terminal, as JSON, and as the page docs/speed.md."""

from collections.abc import Sequence
from typing import Any

from kite_analysis.console.tables import table
from sim_bridge.bench.loops import BEFORE, Comparison, machine
from sim_bridge.native.choice import COMPILED, INTERPRETED

_RATIOS = ((COMPILED, INTERPRETED), (COMPILED, BEFORE), (INTERPRETED, BEFORE))

_PAGE = """\
# Speed

How fast flights are simulated by one process on one core: times real time, the median of {runs} flights of
{seconds:g} s with the least and the most, and how many times as fast one loop is as another (the median of the single
rounds, in which they fly in turn). Made by `kite-sitl bench{command}` on {machine}.

- **compiled**: the firmware's files and the bridge's, as machine code (`make compiled`).
- **interpreted**: the same files, as CPython runs them. Both fly the same to the last bit.
{before}
{table}

What a tick of the firmware with its runtime, and a step of the plant, take on average [us]:

{parts}

The plants with forces are compiled by numba in either loop, so that the firmware's share of their time is smaller. A
ratio holds on other machines, too; a factor does not.
"""
_BEFORE = "- **before**: another version of the project, interpreted.\n"


def as_json(compared: Sequence[Comparison]) -> dict[str, Any]:
    """All numbers, by scenario."""
    return {
        "machine": machine(),
        "scenarios": {one.scenario: {
            "speeds": {loop: speed._asdict() for loop, speed in one.speeds.items()},
            "ratios": {f"{loop}/{other}": ratio for (loop, other), ratio in one.ratios.items()}} for one in compared},
    }


def lines(compared: Sequence[Comparison]) -> list[str]:
    """The table, for a terminal: times real time, median (least to most)."""
    head = _head(compared)
    if len(_pairs(compared)) == 1:
        *head, _ = head
        head.append("ratio")
    rows = [head, *(_row(one, compared) for one in compared)]
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    text = ["  ".join(cell.ljust(width) if index == 0 else cell.rjust(width)
                      for index, (cell, width) in enumerate(zip(row, widths, strict=True))) for row in rows]
    return ["times real time, median (least to most):", *text]


def page(compared: Sequence[Comparison], duration_s: float, runs: int) -> str:
    """The page, as Markdown."""
    loops = list(_loops(compared))
    parts = [[one.scenario, *(f"{value:.1f}" for loop in loops for value in
                              (one.speeds[loop].tick_us, one.speeds[loop].step_us))] for one in compared]
    head = ["scenario", *(f"{loop}: {part}" for loop in loops for part in ("tick", "step"))]
    return _PAGE.format(
        runs=runs, seconds=duration_s, command=" --before DIR" if BEFORE in loops else "", machine=machine(),
        before=_BEFORE if BEFORE in loops else "",
        table=table(_head(compared), [_row(one, compared) for one in compared]).rstrip(),
        parts=table(head, parts).rstrip())


def _loops(compared: Sequence[Comparison]) -> Sequence[str]:
    first, *_ = compared
    return tuple(first.speeds)


def _pairs(compared: Sequence[Comparison]) -> list[tuple[str, str]]:
    first, *_ = compared
    return [pair for pair in _RATIOS if pair in first.ratios]


def _head(compared: Sequence[Comparison]) -> list[str]:
    return ["scenario", *_loops(compared), *(f"{loop} / {other}" for loop, other in _pairs(compared))]


def _row(one: Comparison, compared: Sequence[Comparison]) -> list[str]:
    speeds = [f"{speed.median:.0f} ({speed.least:.0f} to {speed.most:.0f})" for speed in one.speeds.values()]
    return [one.scenario, *speeds, *(f"{one.ratios[pair]:.2f}" for pair in _pairs(compared))]
