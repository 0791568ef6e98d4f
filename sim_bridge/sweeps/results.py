"""The results of a sweep: a CSV file that grows run by run, and from which a killed sweep goes on."""

import csv
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sim_bridge.scenario import ScenarioError

METRICS = (
    "verdict", "cross_track_rms_rad", "cross_track_max_rad", "turning_angle_rms_rad", "steering_rms",
    "saturated_fraction", "sim_s", "trouble",
)
_PLAN = "# "


class Results:
    """Rows by run number. The file's first line holds the plan, so that another sweep cannot go on in it."""

    def __init__(self, path: Path, plan: dict[str, Any], keys: Sequence[str]):
        self.path = path
        self.columns = ["run", "seed", *keys, *METRICS]
        self.rows: dict[int, dict[str, str]] = {}
        self._plan = _PLAN + json.dumps(plan, sort_keys=True)
        try:
            if path.exists():
                self._read()
            else:
                path.parent.mkdir(parents=True, exist_ok=True)
            self._write(path)
            self._file = path.open("a", newline="", encoding="utf-8")
        except OSError as error:
            raise ScenarioError(f"{path}: {error.strerror}") from error
        self._writer = csv.DictWriter(self._file, self.columns)

    def add(self, row: dict[str, Any]) -> None:
        """Take the row of a run that has ended, and have it on disk."""
        self.rows[row["run"]] = {column: str(row[column]) for column in self.columns}
        self._writer.writerow(self.rows[row["run"]])
        self._file.flush()

    def close(self) -> None:
        """Leave the file with its rows in order."""
        self._file.close()
        ordered = self.path.with_name(self.path.name + ".new")
        self._write(ordered)
        ordered.replace(self.path)

    def _read(self) -> None:
        lines = self.path.read_text("utf-8").splitlines(keepends=True)
        if not lines or lines[0].rstrip("\n") != self._plan:
            raise ScenarioError(f"{self.path}: holds something else than this sweep; name another file with --out")
        complete = [line for line in lines[1:] if line.endswith("\n")]
        for row in csv.DictReader(complete):
            if None not in row.values() and row["run"].isdigit():
                self.rows[int(row["run"])] = row

    def _write(self, path: Path) -> None:
        with path.open("w", newline="", encoding="utf-8") as file:
            file.write(self._plan + "\n")
            writer = csv.DictWriter(file, self.columns)
            writer.writeheader()
            writer.writerows(self.rows[run] for run in sorted(self.rows))
