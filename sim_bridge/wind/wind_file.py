"""The mean wind from a CSV file."""

from bisect import bisect_right
from collections.abc import Iterable
from math import fsum, isfinite, radians
from pathlib import Path
from typing import NamedTuple

from sim_bridge.errors import ScenarioError

_NEEDED = ("time_s", "speed_m_s")
_COLUMNS = (*_NEEDED, "direction_deg", "vertical_m_s")
_GREATEST_SPEED = 100.0


class Row(NamedTuple):
    """One line of the file; the direction is unwrapped, so that between two lines the wind turns the short way."""

    time_s: float
    speed: float
    direction_deg: float
    vertical: float


class WindFile:
    """Rows of mean wind, linear in between, held before the first and after the last, or repeated.

    Lines that are blank or begin with # are left out; the first other line names the columns, in any order.

    Raises:
        ScenarioError: the file cannot be read, or a line of it is wrong.
    """

    def __init__(self, path: str, repeat: bool):
        self._repeat = repeat
        self._rows = _read(path)
        self._times = [row.time_s for row in self._rows]
        if repeat and len(self._rows) < 2:
            raise ScenarioError(f"{path}: wind.file_repeat needs at least two lines of numbers")

    def at(self, time_s: float) -> tuple[float, float, float]:
        """Speed [m/s], direction [rad] and vertical wind over speed, at `time_s`."""
        first, last = self._times[0], self._times[-1]
        if self._repeat and time_s > last:
            time_s = first + (time_s - first) % (last - first)
        after = bisect_right(self._times, time_s)
        a, b = self._rows[max(0, after - 1)], self._rows[min(after, len(self._rows) - 1)]
        share = (time_s - a.time_s) / (b.time_s - a.time_s) if b.time_s > a.time_s else 0.0
        speed = a.speed + share * (b.speed - a.speed)
        vertical = (a.vertical + share * (b.vertical - a.vertical)) / speed if speed else 0.0
        return speed, radians(a.direction_deg + share * (b.direction_deg - a.direction_deg)), vertical

    def mean_speed(self) -> float:
        """Mean over time of the speed, first line to last [m/s]."""
        if len(self._rows) == 1:
            return self._rows[0].speed
        ways = [0.5 * (a.speed + b.speed) * (b.time_s - a.time_s)
                for a, b in zip(self._rows, self._rows[1:], strict=False)]
        return fsum(ways) / (self._times[-1] - self._times[0])


def _read(path: str) -> list[Row]:
    try:
        lines = Path(path).read_text("utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not UTF-8 text"
        raise ScenarioError(f"wind.file {path}: {reason}") from error
    columns: list[str] = []
    rows: list[Row] = []
    for number, cells in _filled(lines):
        where = f"{path}:{number}"
        if not columns:
            columns = _checked_columns(cells, where)
            continue
        row = _row(columns, cells, where)
        if rows and row.time_s <= rows[-1].time_s:
            raise ScenarioError(f"{where}: time_s {row.time_s:g} should come after {rows[-1].time_s:g}")
        if rows:
            row = row._replace(direction_deg=_short_way(rows[-1].direction_deg, row.direction_deg))
        rows.append(row)
    if not rows:
        raise ScenarioError(f"{path}: no line of numbers; the file must begin with the line {','.join(_NEEDED)}")
    return rows


def _filled(lines: list[str]) -> Iterable[tuple[int, list[str]]]:
    for number, line in enumerate(lines, 1):
        if line.strip() and not line.lstrip().startswith("#"):
            yield number, [cell.strip() for cell in line.split(",")]


def _checked_columns(cells: list[str], where: str) -> list[str]:
    for name in cells:
        if name not in _COLUMNS:
            raise ScenarioError(f"{where}: no column {name or 'without a name'}; columns are {', '.join(_COLUMNS)}")
        if cells.count(name) > 1:
            raise ScenarioError(f"{where}: column {name} appears twice")
    for name in _NEEDED:
        if name not in cells:
            raise ScenarioError(f"{where}: column {name} is missing")
    return cells


def _row(columns: list[str], cells: list[str], where: str) -> Row:
    if len(cells) != len(columns):
        raise ScenarioError(f"{where}: {len(cells)} values for {len(columns)} columns")
    values: dict[str, float] = dict.fromkeys(_COLUMNS, 0.0)
    for name, cell in zip(columns, cells, strict=True):
        try:
            values[name] = float(cell)
        except ValueError:
            raise ScenarioError(f"{where}: {name} {cell!r} is not a number") from None
        if not isfinite(values[name]):
            raise ScenarioError(f"{where}: {name} {cell} is not finite")
    row = Row(*(values[name] for name in _COLUMNS))
    if not 0.0 <= row.speed <= _GREATEST_SPEED:
        raise ScenarioError(f"{where}: speed_m_s = {row.speed:g} is outside 0 to {_GREATEST_SPEED:g}")
    if abs(row.vertical) > row.speed:
        raise ScenarioError(f"{where}: vertical_m_s = {row.vertical:g} is more than the speed_m_s {row.speed:g}")
    return row


def _short_way(before: float, direction: float) -> float:
    """`direction`, by whole turns as close to `before` as can be [deg]."""
    return before + (direction - before + 180.0) % 360.0 - 180.0
