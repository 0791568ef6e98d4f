"""Reads run logs, complete or truncated, up to where they are valid."""

import json
from pathlib import Path
from typing import Any

from sim_bridge.errors import ScenarioError
from sim_bridge.runs.growing_files import set_aside
from sim_bridge.runs.provenance import scenario_as_logged
from sim_bridge.runs.run_log import COMPLETE_BEFORE, FORMAT, INPUT, RUN, TRUTH
from sim_bridge.scenario.scenario import Scenario

_OLD_FORMAT = 1  # written at the end of a run only: what is there is complete


class LoggedTruth:
    """The truth of a run log: `columns`, and `rows` as texts, up to the first line that is not whole.

    Raises:
        ScenarioError: there is none.
    """

    def __init__(self, folder: Path):
        lines: list[str] = []
        parts = [path for path in (set_aside(folder / TRUTH), folder / TRUTH) if path.exists()]
        if not parts:
            raise ScenarioError(f"{folder / TRUTH} is missing: no record of the flight")
        self.columns: list[str] = []
        self.is_cut = False
        for path in parts:
            header, *rows = _lines(path) or [""]
            self.columns = header.rstrip("\n").split(",") if header else self.columns
            lines += rows
        self.rows: list[list[str]] = []
        for line in lines:
            fields = line.rstrip("\n").split(",")
            if not line.endswith("\n") or len(fields) != len(self.columns) or not all(map(_is_number, fields)):
                self.is_cut = True
                break
            self.rows.append(fields)
        if self.rows and "time_s" not in self.columns:
            raise ScenarioError(f"{folder / TRUTH}: no column time_s")

    def time_s(self, row: int) -> float:
        """Time of a row [s]."""
        return float(self.rows[row][self.columns.index("time_s")])


def read_about(folder: Path) -> dict[str, Any]:
    """What a log's run.json holds.

    Raises:
        ScenarioError: this is not a run log, or not one that this version reads.
    """
    path = folder / RUN
    try:
        about = json.loads(path.read_text("utf-8"))
    except OSError as error:
        raise ScenarioError(f"{path}: {error.strerror}; {folder} is not a run log") from error
    except ValueError as error:
        raise ScenarioError(f"{path}: broken: {error}") from error
    if not isinstance(about, dict) or about.get("format") not in (_OLD_FORMAT, FORMAT):
        raise ScenarioError(f"{path}: not a run log of format {FORMAT}")
    return about


def read_scenario(folder: Path) -> Scenario:
    """The scenario of the run log in `folder`.

    Raises:
        ScenarioError: as `read_about`.
    """
    return scenario_as_logged(read_about(folder), folder)


def read_input(folder: Path, about: dict[str, Any]) -> tuple[dict[int, list[bytes]], float]:
    """Datagrams of ground stations by tick, and the tick from which on they are not known (infinite: none).

    Raises:
        ScenarioError: the log should have them, and has not.
    """
    if not about.get("ground", True):
        return {}, float("inf")
    path = folder / INPUT
    if not path.exists():
        raise ScenarioError(f"{path} is missing: no record of what ground stations sent")
    datagrams: dict[int, list[bytes]] = {}
    known_before = float("inf") if about["format"] == _OLD_FORMAT else float("-inf")
    for line in _lines(path):
        try:
            if not line.endswith("\n"):
                raise ValueError(line)
            if line.startswith(COMPLETE_BEFORE):
                known_before = int(line.removeprefix(COMPLETE_BEFORE))
                continue
            tick, _, text = line.partition(" ")
            datagrams.setdefault(int(tick), []).append(bytes.fromhex(text))
        except ValueError:  # cut off, or broken: all that stands below is of no use
            if about["format"] == _OLD_FORMAT:
                known_before = float(max(datagrams, default=0))
            break
    return datagrams, known_before


def _lines(path: Path) -> list[str]:
    try:
        return path.read_text("ascii", errors="replace").splitlines(keepends=True)
    except OSError as error:
        raise ScenarioError(f"{path}: {error.strerror}") from error


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
