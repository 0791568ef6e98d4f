"""The results of a sweep: a CSV file that grows run by run, from which an interrupted sweep resumes."""

import csv
import io
import json
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from sim_bridge.errors import ScenarioError
from sim_bridge.runs.fingerprint import code_fingerprint

METRICS = (
    "verdict", "cross_track_rms_rad", "cross_track_max_rad", "turning_angle_rms_rad", "steering_rms",
    "saturated_fraction", "sim_s", "trouble", "steering_travel_per_s", "steering_asked_travel_per_s",
    "peak_tether_force_n", "least_elevation_rad",
)
_PLAN = "# "
_CODE = "code"  # column: the fingerprint of the code that flew a run


class Results:
    """Rows by run number. The file's first line holds the plan, so that another sweep cannot go on in it.

    What is in the file stays as it is while the sweep goes on: rows are added at its end, and a file with other
    contents only takes its place when it is whole. `other_code` lets a sweep go on that other code began.

    Raises:
        ScenarioError: the file cannot be used, or holds another sweep's runs, or other code's.
    """

    def __init__(self, path: Path, plan: dict[str, Any], keys: Sequence[str], other_code: bool = False):
        self.path = path
        self.columns = ["run", "seed", *keys, *METRICS, _CODE]
        self.rows: dict[int, dict[str, str]] = {}
        self.flown_by_other_code = 0
        self._plan = _PLAN + json.dumps(plan, sort_keys=True)
        self._code = code_fingerprint()
        try:
            if path.exists():
                self._read()
                self._check_code(other_code)
            else:
                path.parent.mkdir(parents=True, exist_ok=True)
            self._replace()  # without a line that was being written, and with its head if it is new
            self._file = path.open("ab", buffering=0)
        except OSError as error:
            raise self._cannot_write(error) from error
        self._size = path.stat().st_size

    def add(self, row: dict[str, Any]) -> None:
        """Take the row of a run that has ended, and have it on disk.

        Raises:
            ScenarioError: the disk is full; what was there before still is.
        """
        row = row | {_CODE: self._code}
        taken = {column: str(row[column]) for column in self.columns}
        line = _csv_lines(self.columns, [taken])
        try:
            left = memoryview(line)
            while left:  # a disk that fills up takes a part first
                left = left[self._file.write(left) :]
        except OSError as error:
            self._file.truncate(self._size)
            raise self._cannot_write(error) from error
        self._size += len(line)
        self.rows[row["run"]] = taken

    def close(self) -> None:
        """Leave the file with its rows in order; if there is no room for a copy, in the order in which they ended."""
        self._file.close()
        with suppress(OSError):
            self._replace()

    def _read(self) -> None:
        lines = self.path.read_text("utf-8").splitlines(keepends=True)
        if not lines or lines[0].rstrip("\n") != self._plan:
            raise ScenarioError(f"{self.path}: holds results of another sweep; name another file with --out")
        complete = [line for line in lines[1:] if line.endswith("\n")]
        for row in csv.DictReader(complete):
            if row.keys() == set(self.columns) and None not in row.values() and row["run"].isdigit():
                self.rows[int(row["run"])] = row

    def _check_code(self, other_code: bool) -> None:
        self.flown_by_other_code = sum(row[_CODE] != self._code for row in self.rows.values())
        if self.flown_by_other_code and not other_code:
            raise ScenarioError(
                f"{self.path}: {self.flown_by_other_code} of its runs were flown by other code: name another file with "
                "--out, or resume with --other-code (the column `code` tells them apart)")

    def _replace(self) -> None:
        """Put a file with all rows in order into the place of the present one, in one step."""
        new = self.path.with_name(self.path.name + ".new")
        try:
            with new.open("wb") as file:
                rows = [self.rows[run] for run in sorted(self.rows)]
                file.write(f"{self._plan}\n".encode() + _csv_lines(self.columns, rows, head=True))
            new.replace(self.path)
        except OSError:
            new.unlink(missing_ok=True)
            raise

    def _cannot_write(self, error: OSError) -> ScenarioError:
        there = f"; {len(self.rows)} runs are in it; the same command resumes" if self.rows else ""
        return ScenarioError(f"{self.path}: {error.strerror}{there}")


def _csv_lines(columns: Sequence[str], rows: Sequence[dict[str, str]], head: bool = False) -> bytes:
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, columns)
    if head:
        writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().encode()
