"""Logs of flights and recordings that were killed, suspended or out of disk at random moments, ten of each."""

import os
import random
import resource
import signal
import subprocess
import sys
import time

import pytest

from ground.cli.main import main as kite_ground
from tests.sim_bridge.killed_flights import MINE, FlightProcess, opens_everywhere, repeats

pytestmark = pytest.mark.soak
MOMENTS = [(seed, random.Random(seed).uniform(0.0, 1.0)) for seed in range(10)]
SUSPENDED_S = 15.0


@pytest.mark.parametrize(("seed", "after_s"), MOMENTS)
@pytest.mark.parametrize("victim", ["bridge", "firmware"])
def test_a_killed_flight_is_there_up_to_the_last_second(tmp_path, capsys, victim, seed, after_s):
    flight = FlightProcess(tmp_path / "log", "--forever", "--speed", str(1 + 3 * (seed % 3)))
    if victim == "bridge":
        flight.fly_until(6.0 + seed)
        firmware = flight.firmware()
        time.sleep(after_s)
        flight.process.kill()
        flight.end()
        os.kill(firmware, signal.SIGKILL)  # it would wait for its bridge for half a minute
    else:
        flight.fly_until(6.0 + seed)
        firmware = flight.firmware()
        time.sleep(after_s)
        os.kill(firmware, signal.SIGKILL)
        code, said = flight.end()
        assert code == 2 and "Traceback" not in said
        assert "the firmware ended" in said.splitlines()[-1]
    if seed % 3:
        repeats(flight.folder, capsys, flight.shown_s - 1.0)
    opens_everywhere(flight.folder, capsys)


@pytest.mark.parametrize(("seed", "after_s"), MOMENTS)
def test_a_killed_recording_is_there_up_to_the_last_second(tmp_path, seed, after_s):
    flight = FlightProcess(tmp_path / "log", "--forever", "--speed", "1")
    flight.fly_until(1.0)
    path = tmp_path / "flight.tlog"
    recorder = subprocess.Popen(
        [sys.executable, "-c", "import sys; from ground.cli.main import main; sys.exit(main())",
         "--link", f"udpin:127.0.0.1:{flight.send_to}", "record", str(path)],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while not path.exists() or not path.stat().st_size:
        assert recorder.poll() is None
        time.sleep(0.05)
    time.sleep(3.0 + after_s)
    killed_at = time.time()
    recorder.kill()
    recorder.wait()
    firmware = flight.firmware()
    flight.process.kill()
    os.kill(firmware, signal.SIGKILL)
    flight.end()
    assert kite_ground(["plot", str(path), "--out", str(tmp_path / "flight.png")]) == 0
    assert kite_ground(["log", "export", str(path), "--out", str(tmp_path / "flight.csv")]) == 0
    times = [float(line.split(",")[0]) for line in (tmp_path / "flight.csv").read_text().splitlines()[1:]]
    assert killed_at - times[-1] < 1.2 and times[-1] - times[0] > 1.0


@pytest.mark.parametrize("victim", ["bridge", "firmware"])
@pytest.mark.parametrize("speed", ["1", "4"])
def test_a_suspended_flight_loses_nothing(tmp_path, capsys, victim, speed):
    flight = FlightProcess(tmp_path / "log", "--duration", "40", "--speed", speed)
    flight.fly_until(6.0)
    process = flight.process.pid if victim == "bridge" else flight.firmware()
    os.kill(process, signal.SIGSTOP)
    time.sleep(SUSPENDED_S)
    os.kill(process, signal.SIGCONT)
    code, said = flight.end()
    assert code == 0 and said == "", said
    if speed != "1":
        numbers = repeats(flight.folder, capsys, 39.99)
        assert numbers["cut"] is None
    opens_everywhere(flight.folder, capsys)


@pytest.mark.parametrize("room_kb", [150, 400])
def test_a_full_disk_does_not_end_the_flight(tmp_path, capsys, room_kb):
    """A disk of its own where that is allowed, else a limit on each file."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={room_kb}k", "tmpfs", str(disk)], check=False,
                             capture_output=True).returncode == 0
    room = 1000 * room_kb // 3

    def limit():
        if not mounted:
            resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))

    try:
        flight = FlightProcess(disk / "log", "--duration", "40", "--speed", "8", setup=limit)
        flight.fly_until(2.0)
        code, said = flight.end()
        assert code == 0 and flight.shown_s >= 39.0, (said, flight.lines)
        assert len(said.splitlines()) == 1 and "the flight goes on" in said, said
        numbers = repeats(flight.folder, capsys, 2.0)
        assert numbers["cut"]
        assert (flight.folder / "notes.txt").read_text() == MINE
    finally:
        if mounted:
            subprocess.run(["umount", str(disk)], check=True)


