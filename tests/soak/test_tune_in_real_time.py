"""`tune` beside a simulator that flies in real time, the firmware on a clock of its own: five times of five."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROUNDS = 5
KITE_GROUND = str(Path(sys.executable).with_name("kite-ground"))
SITL = ("--runtime", "cpython", "--speed", "1", "--ground", "--forever")
TUNE = (("tune", "--yes", "--json"), ("tune", "--step", "+10%", "--yes", "--json"),
        ("tune", "--identify", "--yes", "--json"))


@pytest.fixture(params=["paper-delay-tuned", "small-kite", "v3-flight"])
def link(request, tmp_path):
    """As `make sitl` flies it (paper-delay-tuned) or `kite-sitl run`, on ports of its own."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [sys.executable, "-m", "sim_bridge.cli.main", "run", request.param, *SITL, "--status", "--log",
               str(tmp_path / "log"), "--set", f"ground.send_to=127.0.0.1:{port}", "--set", "ground.listen=127.0.0.1:0"]
    said = tmp_path / "said"
    with said.open("w") as output, subprocess.Popen(command, stdout=output) as sitl:
        while " TRACK " not in said.read_text():
            assert sitl.poll() is None
            time.sleep(0.5)
        yield f"udpin:127.0.0.1:{port}"
        sitl.send_signal(signal.SIGINT)


@pytest.mark.soak
def test_tune_ends_well_five_times_of_five(link, tmp_path):
    """Each ends with 0, finds the delay, keeps only what flew better, and `param revert` goes back after it."""
    environment = {**os.environ, "XDG_STATE_HOME": str(tmp_path / "state")}

    def ground(*arguments: str) -> str:
        done = subprocess.run([KITE_GROUND, "--link", link, *arguments], capture_output=True,
                              text=True, check=False, env=environment)
        assert done.returncode == 0, (arguments, done.stderr)
        return done.stdout

    for _ in range(ROUNDS):
        delays_s = []
        for command in TUNE:
            found = json.loads(ground(*command))
            delays_s.append(found["delay_s"])
            tried = found.get("step") or found
            if found["written"] and tried.get("after"):
                assert tried["after"]["cross_track_rad"] <= tried["before"]["cross_track_rad"]
        assert max(delays_s) < 1.5 * min(delays_s)
        ground("param", "revert", "--yes")
