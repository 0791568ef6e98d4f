"""Parameter files of MAVProxy, Mission Planner and QGroundControl: reads any of the three, writes each.

    MAVProxy         NAME value
    Mission Planner  NAME,value
    QGroundControl   system <tab> component <tab> NAME <tab> value <tab> type
"""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from ground.errors import UsageError
from protocol import dialect
from protocol.parameter_table import NAME_LENGTH
from protocol.single_precision import float32

STYLES: dict[str, Callable[[str, str, int], str]] = {
    "mavproxy": lambda name, value, system: f"{name:<{NAME_LENGTH}} {value}",
    "missionplanner": lambda name, value, system: f"{name},{value}",
    "qgroundcontrol": lambda name, value, system: "\t".join(
        (str(system), str(dialect.MAV_COMP_ID_AUTOPILOT1), name, value, str(dialect.MAV_PARAM_TYPE_REAL32))),
}
_TITLES = {"qgroundcontrol": ["# Vehicle-Id Component-Id Name Value Type"]}


class ParameterFileError(UsageError):
    """A parameter file cannot be read or written; the message names the file and the line."""


class Entry(NamedTuple):
    """A value (float32), and its line in the file, counted from 1."""

    value: float
    line: int


class ParameterFile(NamedTuple):
    """A file's parameters by name, in its order, and (line, problem) for each bad line."""

    entries: dict[str, Entry]
    problems: list[tuple[int, str]]


def scan_parameter_file(path: str | Path) -> ParameterFile:
    """Read a file, keeping the problems of bad lines.

    Raises:
        ParameterFileError: there is no such file, or it is not text, or empty.
    """
    try:
        text = Path(path).read_text("utf-8-sig")
    except OSError as error:
        raise ParameterFileError(f"{path}: cannot read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ParameterFileError(f"{path}: not a text file: expected lines of NAME value") from None
    entries: dict[str, Entry] = {}
    problems: list[tuple[int, str]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        try:
            if (parsed := _parse_line(line)) is None:
                continue
            name, value = parsed
            if name in entries:
                raise ValueError(f"{name} is already given in line {entries[name].line}")
            entries[name] = Entry(value, number)
        except ValueError as error:
            problems.append((number, str(error)))
    if not entries and not problems:
        raise ParameterFileError(f"{path}: holds no parameters: expected lines of NAME value")
    return ParameterFile(entries, problems)


def read_parameter_file(path: str | Path) -> dict[str, Entry]:
    """The parameters in a file, by name, in the file's order.

    Raises:
        ParameterFileError: no such file, a line that is not a parameter, a repeated name, or no parameters at all.
    """
    entries, problems = scan_parameter_file(path)
    if problems:
        number, problem = problems[0]
        raise ParameterFileError(f"{path}:{number}: {problem}")
    return entries


def write_parameter_file(path: str | Path, values: dict[str, float], heading: Sequence[str],
                         style: str = "mavproxy", system: int = 1) -> None:
    """Write `values` in one of STYLES, below the comment lines `heading`; all or nothing.

    `system` is the vehicle's id, which QGroundControl's format needs.

    Raises:
        ParameterFileError: the file cannot be written.
    """
    lines = [f"# {line}" for line in heading] + _TITLES.get(style, [])
    lines += [STYLES[style](name, format_value(value), system) for name, value in values.items()]
    unfinished = Path(f"{path}.part")
    try:
        unfinished.write_text("\n".join(lines) + "\n", "utf-8")
        unfinished.replace(path)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise ParameterFileError(f"{path}: cannot write: {error.strerror}") from None


def parse_number(text: str) -> float:
    """The finite float32 that `text` gives.

    Raises:
        ValueError: it is not a number, or not finite as a float32.
    """
    try:
        value = float32(float(text))
    except ValueError:
        raise ValueError(f"{text!r} is not a number") from None
    if not math.isfinite(value):
        raise ValueError(f"{text!r} is not a finite number that a float32 holds")
    return value


def format_value(value: float) -> str:
    """The shortest decimal text that reads back as this float32."""
    if value == int(value) and abs(value) < 1e9:
        return str(int(value))
    return next((text for digits in range(1, 9) if float32(float(text := f"{value:.{digits}g}")) == value),
                f"{value:.9g}")


def _parse_line(line: str) -> tuple[str, float] | None:
    """Name and value of a line, or None for an empty one. Raises ValueError if it is malformed."""
    content = line.partition("#")[0].strip()
    if not content:
        return None
    columns = content.split("\t")
    if len(columns) == 5:
        _system, _component, name, number, _type = (column.strip() for column in columns)
    else:
        words = content.replace(",", " ").split()
        if len(words) != 2:
            raise ValueError(f"{_shortened(content)!r} is not a parameter: expected NAME value")
        name, number = words
    if len(name) > NAME_LENGTH or not name.isascii() or not name.replace("_", "").isalnum():
        raise ValueError(f"{_shortened(name)!r} is not a parameter name: must be at most {NAME_LENGTH} letters, "
                         "digits and _")
    return name, parse_number(number)


def _shortened(text: str) -> str:
    return text if len(text) <= 40 else text[:37] + "..."
