"""What a board says about itself, and the script that makes it say so."""

from typing import NamedTuple

from sim_bridge.errors import BoardError

LEAST_VERSION = (1, 28)

# Runs on the board; imports nothing of ours, so that it runs on a board with nothing on it.
SCRIPT = """
import sys, os
print("kitepilot-probe", sys.platform, sys.implementation.name, sys.implementation.version[0], \
sys.implementation.version[1])
try:
    s = os.statvfs("/")
    print("free", s[0], s[3])
except OSError:
    print("no-file-system")
import hashlib, binascii
def one(name):
    try:
        with open(name, "rb") as f:
            h = hashlib.sha256()
            while True:
                b = f.read(512)
                if not b:
                    break
                h.update(b)
        print("file", os.stat(name)[6], binascii.hexlify(h.digest()).decode(), name)
    except OSError:
        pass
one("main.py")
one("board.py")
def all_in(folder):
    for entry in os.ilistdir(folder):
        name = folder + "/" + entry[0]
        if entry[1] == 0x4000:
            all_in(name)
        else:
            one(name)
try:
    all_in("firmware_py")
except OSError:
    pass
"""


class OnBoard(NamedTuple):
    """A file on the board."""

    size: int
    sha256: str


class Probe(NamedTuple):
    """A board: its sys.platform, its free flash in bytes and the size of a block, and the files we know of."""

    platform: str
    version: tuple[int, int]
    block: int
    free: int
    files: dict[str, OnBoard]


def read_probe(text: str) -> Probe:
    """Read what SCRIPT printed.

    Raises:
        BoardError: no MicroPython answered, or one that is too old, or there is no file system.
    """
    rows = [line.split() for line in text.splitlines()]
    head = next((row for row in rows if row[:1] == ["kitepilot-probe"]), None)
    _, platform, implementation, major, minor, *_ = head or [""] * 5
    if implementation != "micropython":
        raise BoardError("no MicroPython answers there: put MicroPython 1.28 or newer onto the board first")
    version = int(major), int(minor)
    if version < LEAST_VERSION:
        raise BoardError(f"MicroPython {major}.{minor} on the board is too old: 1.28 or newer is needed")
    if ["no-file-system"] in rows:
        raise BoardError("MicroPython on the board can neither read its flash nor format it: put MicroPython onto it "
                         "again, and if that does not help, take another board")
    block, free = 4096, 0
    files = {}
    for kind, *fields in filter(None, rows):
        if kind == "free":
            block, blocks = map(int, fields)
            free = block * blocks
        elif kind == "file":
            size, digest, name = fields
            files[name] = OnBoard(int(size), digest)
    return Probe(platform, version, block, free, files)
