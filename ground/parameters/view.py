"""Parameters as text: values with unit, limits and meaning, and differences."""

import shutil
import sys

from ground.parameters.file import format_value
from protocol.parameter_table import Parameter

Values = dict[str, float]


def width() -> int | None:
    """Columns of the terminal, or None if the output goes elsewhere and must not be cut."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else None


def row(name: str, parameter: Parameter | None, value: float) -> str:
    """A line of a list: * if not at the default, name, value, unit, limits, first clause of the documentation."""
    mark = "*" if is_changed(parameter, value) else " "
    if parameter is None:
        return f"{mark} {name:<16} {format_value(value):>12}        not known to this ground station"
    return (f"{mark} {name:<16} {format_value(value):>12} {parameter.unit:<6} {limits(parameter):>14}  "
            f"{short(parameter.text)}").rstrip()


def sheet(name: str, parameter: Parameter, value: float) -> list[str]:
    """One parameter in full, as lines."""
    notes = [f"{limits(parameter)} {parameter.unit}".rstrip(), f"default {parameter.default:g}"]
    notes += ["read-only"] if parameter.read_only else ["only while disarmed"] if parameter.disarmed_only else []
    return [f"{name} = {format_value(value)} {parameter.unit}".rstrip(), f"  {parameter.text}", f"  {', '.join(notes)}"]


def differences(table: dict[str, Parameter], present: Values, other: Values, heading: str) -> list[str]:
    """A table of `other` values next to the vehicle's `present` ones, with units and meaning."""
    lines = [f"{'':<16} {'kite':>12} {heading:>12}"]
    for name, value in other.items():
        parameter = table.get(name)
        about = f" {parameter.unit:<6} {short(parameter.text)}" if parameter else ""
        now = format_value(present[name]) if name in present else "-"
        lines.append(f"{name:<16} {now:>12} {format_value(value):>12}{about}".rstrip())
    return lines


def facts(parameter: Parameter | None, value: float) -> dict[str, float | str | None]:
    """One parameter as a dictionary, for scripts."""
    shortest = float(format_value(value))
    if parameter is None:
        return {"value": shortest, "unit": None, "default": None, "least": None, "greatest": None, "text": None}
    return {"value": shortest, "unit": parameter.unit, "default": parameter.default, "least": parameter.least,
            "greatest": parameter.greatest, "text": parameter.text}


def is_changed(parameter: Parameter | None, value: float) -> bool:
    """Whether it is known to differ from its default."""
    return parameter is not None and value != parameter.default


def limits(parameter: Parameter) -> str:
    """Least and greatest value."""
    return parameter.range_text


def short(text: str) -> str:
    """The first clause of a parameter's documentation."""
    for end in (";", ":"):
        text = text.partition(end)[0]
    return text.rstrip(".")


def counted(number: int) -> str:
    """The number with its noun: "1 parameter", "2 parameters"."""
    return f"{number} parameter{'' if number == 1 else 's'}"
