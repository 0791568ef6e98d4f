"""What a board says about itself, and the script that makes it say so."""

from typing import NamedTuple

from sim_bridge.boards.image import BoardError

LEAST_VERSION = (1, 28)

# Runs on the board; imports nothing of ours, so that it runs on a board with nothing on it.
SCRIPT = """
import sys, os
print("kitepilot-probe", sys.platform, sys.implementation.name, sys.implementation.version[0], \
sys.implementation.version[1])
s = os.statvfs("/")
print("free", s[0], s[3])
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
        BoardError: no MicroPython answered, or one that is too old.
    """
    rows = [line.split() for line in text.splitlines()]
    head = next((row for row in rows if row and row[0] == "kitepilot-probe"), None)
    if head is None or head[2] != "micropython":
        raise BoardError("no MicroPython answers there: put MicroPython 1.28 or newer onto the board first")
    version = int(head[3]), int(head[4])
    if version < LEAST_VERSION:
        raise BoardError(f"MicroPython {version[0]}.{version[1]} on the board is too old: 1.28 or newer is needed")
    block, free = 4096, 0
    files = {}
    for row in rows:
        if row and row[0] == "free":
            block, free = int(row[1]), int(row[1]) * int(row[2])
        elif row and row[0] == "file":
            files[row[3]] = OnBoard(int(row[1]), row[2])
    return Probe(head[1], version, block, free, files)
