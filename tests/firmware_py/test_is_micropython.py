"""The firmware is MicroPython: it imports nothing else, compiles there, and gives the same bytes."""

import ast
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from firmware_py.mavlink.encoder import LONGEST_FRAME, Encoder
from firmware_py.mavlink.generated_messages import HIL_ACTUATOR_CONTROLS
from sim_bridge.boards.constants import is_for_types

ROOT = Path(__file__).parents[2]
FIRMWARE = sorted((ROOT / "firmware_py").rglob("*.py"))
EVERYWHERE = {"array", "asyncio", "binascii", "collections", "errno", "gc", "hashlib", "io", "json", "math",
              "micropython", "os", "random", "select", "socket", "struct", "sys", "time"}
ON_BOARDS = {"esp", "esp32", "machine", "network", "rp2", "uctypes"}
OF_THE_USER = {"board"}  # the file with a board's settings, which lies beside the firmware
EACH_FILE = pytest.mark.parametrize("file", FIRMWARE, ids=lambda file: f"{file.parent.name}-{file.stem}")


def beside_python(command: str) -> str | None:
    """A command of this environment, or of the path."""
    return shutil.which(command, path=str(Path(sys.executable).parent)) or shutil.which(command)


MICROPYTHON = beside_python("micropython")
needs_micropython = pytest.mark.skipif(not MICROPYTHON, reason="no micropython here (no wheel for this platform)")


def on_micropython(program: str) -> str:
    """Output of `program` under MicroPython with the heap of a small board; its words on stderr if it fails."""
    done = subprocess.run([str(MICROPYTHON), "-X", "heapsize=192k", "-c", program], cwd=ROOT, capture_output=True,
                          text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.strip()


def test_there_are_files_to_check():
    assert len(FIRMWARE) > 15


def as_run(file: Path) -> ast.Module:
    """The syntax tree of a file without what only type checkers look at."""
    tree = ast.parse(file.read_text("utf-8"))
    tree.body = [node for node in tree.body if not is_for_types(node)]
    return tree


def imported(nodes) -> set[str]:
    """Modules that the import statements among `nodes` name, bar relative ones."""
    names = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names.add(str(node.module))
    return names


@EACH_FILE
def test_only_itself_and_micropythons_modules_are_imported(file):
    """What only boards have is imported by the boards' own modules, and by others not before it is needed."""
    tree = as_run(file)
    assert imported(ast.walk(tree)) <= EVERYWHERE | ON_BOARDS | OF_THE_USER
    if file.parent.name != "boards":
        assert imported(tree.body) <= EVERYWHERE
    depth = len(file.relative_to(ROOT / "firmware_py").parts)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            assert node.level <= depth, "a relative import that leaves the folder"


@EACH_FILE
def test_nothing_is_used_that_micropython_does_not_have(file):
    """What compiles there and only fails when it runs; the rest is for mpy-cross."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            assert node.func.id != "sum", "CPython's sum() compensates floats"
        if isinstance(node, ast.Attribute):
            assert node.attr not in ("hypot", "bit_length", "hexdigest")
        if isinstance(node, ast.ImportFrom):
            assert not {alias.name for alias in node.names} & {"hypot"}


@EACH_FILE
def test_every_file_compiles(file):
    mpy_cross = beside_python("mpy-cross")
    if not mpy_cross:
        pytest.skip("no mpy-cross here")
    done = subprocess.run([mpy_cross, "-march=x64", "-o", "/dev/null", str(file)], capture_output=True, text=True,
                          check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@needs_micropython
def test_the_whole_firmware_loads():
    assert on_micropython("import firmware_py.main; print(firmware_py.main.__name__)") == "firmware_py.main"


@needs_micropython
def test_frames_are_the_same_bytes_there_and_found_again():
    """Whichever checksum the platform has, in native code or not."""
    values = (123456789, 1, 0.1, *(0.0,) * 15, 0)
    buffer = bytearray(LONGEST_FRAME)
    end = Encoder(7, 1).encode(buffer, 0, HIL_ACTUATOR_CONTROLS, values)
    program = f"""
from firmware_py.mavlink.encoder import Encoder
from firmware_py.mavlink.decoder import Decoder
buffer = bytearray({LONGEST_FRAME})
end = Encoder(7, 1).encode(buffer, 0, {HIL_ACTUATOR_CONTROLS}, {values!r})
decoder = Decoder()
decoder.feed(bytes(9) + bytes(buffer[:end]))
print(bytes(buffer[:end]).hex(), decoder.next_frame(), decoder.message, decoder.values[0], decoder.bad_crc)
"""
    assert on_micropython(program) == f"{bytes(buffer[:end]).hex()} True {HIL_ACTUATOR_CONTROLS} 123456789 0"


@needs_micropython
def test_it_leaves_room_on_a_small_heap():
    """Compiled from its sources, the hardest case. Interned names double their table at some number: 14 KB at once.

    The steering's history takes 8 KB of it here, and half of that on a board, where a small integer is 4 bytes long.
    """
    free = on_micropython("""
import gc
gc.threshold(4096)
from firmware_py.autopilot import Autopilot
from firmware_py.loop import step_lockstep
from firmware_py.mavlink.link import MavlinkLink
gc.collect()
print(gc.mem_free())
""")
    assert int(free) > 36_000, "fewer names, modules or tables: a tick needs some 20 KB of this, in one piece"
