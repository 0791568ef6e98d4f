"""The meaning of a recorded flight's columns, from a small TOML file, so that any team's logs can be read.

    title = "..."                     # said above the results
    attribution = "..."               # shown wherever the data or a result from it is shown
    smoothing_s = 1.1                 # width of the smoothing of the heading rate; 0 for data without noise
    smooth_both = true                # smooth the law's other side too, so that sharp turns are not flattened

    [columns]                         # one entry a quantity, see QUANTITIES
    airspeed = { column = "va", unit = "km/h", sign = 1, optional = false, max_gap_s = 2.5 }

    [phase]                           # optional: only rows with one of these values are used
    column = "phase"
    values = ["reel-out"]

For a time in two columns, whole seconds and fraction, name both:

    time = { column = "seconds", unit = "s", fraction = "micros", fraction_unit = "us" }

`factor = 0.01` may stand for `unit`. Values become SI units, radians, and steering of -1 to 1, in the project's
signs. A gap longer than `max_gap_s` is left out. `set_steering` may say
`holds = "since_previous_row"` when a new command in a row means that it was given since the row before; otherwise it
holds "until_next_row".
"""

import math
import tomllib
from pathlib import Path
from typing import Any, NamedTuple

_FOLDER = Path(__file__).parent / "descriptions"
PUBLIC_FLIGHT = _FOLDER / "v3_20191008.toml"
SIMULATED_RUN = _FOLDER / "simulated_run.toml"

_SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_ANGLE = {"rad": 1.0, "deg": math.pi / 180.0}
_LENGTH = {"m": 1.0, "km": 1000.0}
_SPEED = {"m/s": 1.0, "km/h": 1.0 / 3.6, "kn": 1852.0 / 3600.0}
_FORCE = {"N": 1.0, "kN": 1000.0, "kgf": 9.80665}
_SHARE = {"1": 1.0, "%": 0.01}
_FAST_S, _SLOW_S = 0.5, 2.5  # longest gaps that are bridged: of what turns with the kite, and of the rest
# Quantity: its units, and the longest gap in it that is bridged unless the file says otherwise.
QUANTITIES: dict[str, tuple[dict[str, float], float]] = {
    "time": (_SECONDS, 0.0), "azimuth": (_ANGLE, _FAST_S), "elevation": (_ANGLE, _FAST_S),
    "course": (_ANGLE, _FAST_S), "heading": (_ANGLE, _FAST_S), "steering": (_SHARE, _FAST_S),
    "set_steering": (_SHARE, _FAST_S), "airspeed": (_SPEED, _SLOW_S), "distance": (_LENGTH, _SLOW_S),
    "tether_force": (_FORCE, _SLOW_S),
}
_HOLDS = ("until_next_row", "since_previous_row")


class FlightDataError(Exception):
    """A file cannot be read or used as a flight; the text says what is wrong and where, in one line."""


class Column(NamedTuple):
    """Column of a quantity: the file's value times `factor` is the value used."""

    column: str
    factor: float
    optional: bool
    max_gap_s: float
    since_previous_row: bool
    fraction: str = ""  # of the time: the column that holds the rest, and its factor
    fraction_factor: float = 0.0


class ColumnDescription(NamedTuple):
    """What the columns of a kind of file mean. `phase_values` empty: every row is used."""

    title: str
    attribution: str
    smoothing_s: float
    smooth_both: bool
    columns: dict[str, Column]
    phase_column: str
    phase_values: tuple[Any, ...]
    path: Path  # where it stands

    @property
    def own(self) -> bool:
        """Whether a user wrote it."""
        return self.path.parent != _FOLDER


def load_description(path: Path) -> ColumnDescription:
    """Read the description at `path`.

    Raises:
        FlightDataError: it cannot be read, or is invalid.
    """
    try:
        content = tomllib.loads(path.read_text("utf-8"))
    except OSError as error:
        raise FlightDataError(f"{path}: {error.strerror}") from error
    except ValueError as error:
        raise FlightDataError(f"{path}: not TOML: {error}") from error
    if not content:
        raise FlightDataError(f"{path}: no [columns]; see docs/flight-files.md")
    _check_keys(content, {"title": str, "attribution": str, "smoothing_s": (int, float), "smooth_both": bool,
                          "columns": dict, "phase": dict}, str(path))
    columns = {quantity: _column(quantity, entry, f"{path}, columns.{quantity}")
               for quantity, entry in content.get("columns", {}).items()}
    for needed in ("time", "elevation", "airspeed"):
        if needed not in columns:
            raise FlightDataError(f"{path}: columns.{needed} is missing")
    for one, other in (("heading", "course"), ("steering", "set_steering")):
        if one not in columns and other not in columns:
            raise FlightDataError(f"{path}: neither columns.{one} nor columns.{other} is given; one of them is needed")
    smoothing_s = float(content.get("smoothing_s", 1.1))
    if not 0.0 <= smoothing_s < 60.0:
        raise FlightDataError(f"{path}: smoothing_s = {smoothing_s:g} must be between 0 and 60")
    phase = content.get("phase", {})
    if phase:
        _check_keys(phase, {"column": str, "values": list}, f"{path}, phase")
        if "column" not in phase or not phase.get("values"):
            raise FlightDataError(f"{path}, phase: needs column = \"...\" and values = [...]")
        if not all(type(value) in (str, int, float) for value in phase["values"]):
            raise FlightDataError(f"{path}, phase: values must be numbers or strings")
    return ColumnDescription(content.get("title", path.stem), content.get("attribution", ""), smoothing_s,
                             content.get("smooth_both", True), columns, phase.get("column", ""),
                             tuple(phase.get("values", ())), path)


def no_phase(description: ColumnDescription) -> str:
    """The message for a file without a row in the described phase."""
    values = ", ".join(str(value) for value in description.phase_values)
    return f"no row has {description.phase_column} {values}"


def _column(quantity: str, entry: Any, where: str) -> Column:
    """One entry of [columns]."""
    if quantity not in QUANTITIES:
        raise FlightDataError(f"{where}: no such quantity; there are {', '.join(QUANTITIES)}")
    units, max_gap_s = QUANTITIES[quantity]
    if not isinstance(entry, dict) or not isinstance(entry.get("column"), str):
        raise FlightDataError(f"{where}: needs column = \"...\", the name in the file")
    number = (int, float)
    _check_keys(entry, {"column": str, "unit": str, "factor": number, "sign": number, "optional": bool,
                        "max_gap_s": number, "holds": str, "fraction": str, "fraction_unit": str}, where)
    if ("unit" in entry) == ("factor" in entry):
        raise FlightDataError(f"{where}: needs either unit or factor")
    if "unit" in entry and entry["unit"] not in units:
        raise FlightDataError(f"{where}: unit \"{entry['unit']}\" is none of {', '.join(units)}")
    factor = float(entry["factor"]) if "factor" in entry else units[entry["unit"]]
    if not math.isfinite(factor) or factor == 0.0:
        raise FlightDataError(f"{where}: factor = {factor:g} must be finite and not 0")
    sign = entry.get("sign", 1)
    if sign not in (1, -1):
        raise FlightDataError(f"{where}: sign = {sign} must be 1 or -1")
    max_gap_s = float(entry.get("max_gap_s", max_gap_s))
    if not 0.0 <= max_gap_s < math.inf:
        raise FlightDataError(f"{where}: max_gap_s = {max_gap_s:g} must be 0 or longer")
    holds = entry.get("holds", _HOLDS[0])
    if holds not in _HOLDS or ("holds" in entry and quantity != "set_steering"):
        raise FlightDataError(f"{where}: holds is for set_steering, and one of {', '.join(_HOLDS)}")
    return Column(entry["column"], sign * factor, entry.get("optional", False), max_gap_s, holds == _HOLDS[1],
                  *_fraction(quantity, entry, where))


def _fraction(quantity: str, entry: dict[str, Any], where: str) -> tuple[str, float]:
    """The column with the fraction of the time and its factor; none where there is no such column."""
    if "fraction" not in entry and "fraction_unit" not in entry:
        return "", 0.0
    if quantity != "time" or "fraction" not in entry or entry.get("fraction_unit") not in _SECONDS:
        raise FlightDataError(f"{where}: fraction is for time, and needs fraction_unit, one of {', '.join(_SECONDS)}")
    return entry["fraction"], _SECONDS[entry["fraction_unit"]]


def _check_keys(content: dict[str, Any], known: dict[str, Any], where: str) -> None:
    for key, value in content.items():
        if key not in known:
            raise FlightDataError(f"{where}: unknown key {key}; there are {', '.join(known)}")
        kind = known[key]
        if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
            wanted = {str: "text", dict: "a table", list: "a list", bool: "true or false"}.get(kind, "a number")
            raise FlightDataError(f"{where}: {key} must be {wanted}")
