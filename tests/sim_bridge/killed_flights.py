"""Flights in processes of their own, to be killed: the bridge, its firmware, a ground station that sends."""

import json
import re
import socket
import subprocess
import sys
import threading
from pathlib import Path

from ground.cli.main import main as kite_ground
from protocol import dialect
from sim_bridge.cli.main import main as kite_sitl

MINE = "notes of the pilot\n"


def free_port():
    """A UDP port that nobody uses."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class FlightProcess:
    """`kite-sitl run` into the log `folder`, with status lines, a ground station, and a file of the user's own."""

    def __init__(self, folder: Path, *options: str, setup=None):
        self.folder = folder
        self.port = free_port()
        self.send_to = free_port()
        command = [
            sys.executable, "-m", "sim_bridge.cli.main", "run", "small-kite", "--runtime", "cpython", "--ground",
            "--set", f"ground.send_to=127.0.0.1:{self.send_to}", "--set", f"ground.listen=127.0.0.1:{self.port}",
            "--set", "sensors.noise_rad=0.001", "--status", "--log", str(folder), *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                        preexec_fn=setup)  # noqa: PLW1509  (no thread runs yet)
        self.shown_s = 0.0  # flight time that the last status line gave
        self.lines: list[str] = []
        self._silent = threading.Event()
        self._station = threading.Thread(target=self._send, daemon=True)
        while not self.shown_s and self._read_line():  # not before the flight: what it sets would be set back
            pass
        self._station.start()

    def fly_until(self, time_s: float):
        """Wait for the status line of this flight time [s], and put a file of the user's own into the log's folder."""
        while self.shown_s < time_s and self._read_line():
            pass
        assert self.shown_s >= time_s, self.lines
        (self.folder / "notes.txt").write_text(MINE)

    def end(self):
        """Wait for the end; return the exit code and what was said as an error."""
        while self._read_line():
            pass
        assert self.process.stderr
        said = self.process.stderr.read()
        self._silent.set()
        self._station.join()
        return self.process.wait(), said

    def firmware(self) -> int:
        """Process id of the firmware."""
        for entry in Path("/proc").iterdir():
            if entry.name.isdigit():
                try:
                    fields = (entry / "stat").read_text().rpartition(")")[2].split()
                except OSError:  # it has just ended
                    continue
                if int(fields[1]) == self.process.pid:
                    return int(entry.name)
        raise AssertionError("no firmware")

    def _read_line(self) -> bool:
        assert self.process.stdout
        line = self.process.stdout.readline()
        self.lines.append(line)
        if found := re.match(r" *(\d+) s  ", line):
            self.shown_s = float(found[1])
        return bool(line)

    def _send(self):
        """A ground station that moves a gain to and fro, which changes the flight."""
        station = dialect.MAVLink(None, 250, 190)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            gain = 4.0
            while not self._silent.wait(0.02):
                gain = 9.0 - gain
                message = dialect.MAVLink_param_set_message(
                    1, 1, b"OUTER_L", gain, dialect.MAV_PARAM_TYPE_REAL32)
                sender.sendto(message.pack(station), ("127.0.0.1", self.port))


def repeats(folder: Path, capsys, at_least_s: float) -> dict:
    """What `rerun` says of a cut log: the same to the bit, at least up to there."""
    code = kite_sitl(["rerun", str(folder), "--json"])
    numbers = json.loads(capsys.readouterr().out)
    assert code == 0 and numbers["same"], numbers
    assert numbers["until_s"] >= at_least_s, numbers
    return numbers


def opens_everywhere(folder: Path, capsys):
    """Every reader of run logs takes it; the user's file is untouched."""
    assert kite_sitl(["identify", str(folder), "--json"]) == 0
    assert kite_ground(["plot", str(folder / "ground.tlog"), "--out", str(folder.with_suffix(".png"))]) == 0
    for name in ("control.tlog", "ground.tlog"):
        exported = folder.with_name(f"{folder.name}-{name}.csv")
        assert kite_ground(["log", "export", str(folder / name), "--out", str(exported)]) == 0
        assert exported.stat().st_size > 1000
    capsys.readouterr()
    assert (folder / "notes.txt").read_text() == MINE
