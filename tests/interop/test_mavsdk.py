"""A ground station that nobody here wrote: mavsdk on real sockets, with the real firmware process, on five links."""

import contextlib
import json
import os
import socket
import subprocess
import sys
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import pytest

import ground
from firmware_py.services.message_requests import FIRMWARE_VERSION
from protocol.parameter_table import load_parameters

pytest.importorskip("mavsdk", reason="mavsdk is not installed (extra interop)")

SESSION = Path(__file__).with_name("mavsdk_session.py")
LINKS = {  # keys of the scenario
    "0.1 s one way": {"delay_s": 0.2},
    "0.4 s one way": {"delay_s": 0.8},
    "1.0 s one way": {"delay_s": 2.0},
    "10 % lost": {"delay_s": 0.04, "loss": 0.1},
    "30 % lost": {"delay_s": 0.04, "loss": 0.3},
}
LOSSLESS = ("0.1 s one way", "0.4 s one way")
BEFORE, ASKED = 1.5, 2.75  # INNER_P
LIMIT_S = 30.0  # of a call: mavsdk gives up after so many tries of its own, the list being the longest
TABLE = load_parameters()


def free_ports(count: int) -> list[int]:
    """UDP ports that nobody has."""
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


@contextlib.contextmanager
def simulated_kite(link: dict[str, float], send_to: int, listen: int, folder: Path):
    """A kite in the air, its firmware a process of its own in real time."""
    settings = {f"link.ground.{key}": value for key, value in link.items()}
    settings |= {"ground.send_to": f"127.0.0.1:{send_to}", "ground.listen": f"127.0.0.1:{listen}"}
    arguments = [part for key, value in settings.items() for part in ("--set", f"{key}={value}")]
    with (folder / "sitl.txt").open("w") as said:
        process = subprocess.Popen(
            [sys.executable, "-m", "sim_bridge.cli.main", "run", "paper-delay-tuned", "--runtime", "cpython",
             "--speed", "1",
             "--ground", "--duration", "120", "--param", f"INNER_P={BEFORE}", *arguments], stdout=said, stderr=said)
        try:
            yield
        finally:
            process.kill()
            process.wait()


def fly(link: dict[str, float], folder: Path) -> tuple[dict, float, bool]:
    """What mavsdk's calls came to on a `link`; then INNER_P and whether it is armed, as our own station reads them."""
    folder.mkdir()
    send_to, listen = free_ports(2)
    with simulated_kite(link, send_to, listen, folder):
        done = subprocess.run(
            [sys.executable, str(SESSION), str(send_to)], capture_output=True, text=True, check=False, timeout=100,
            env={**os.environ, "HOME": str(folder), "XDG_CACHE_HOME": str(folder)})  # (it keeps metadata for later)
        assert done.returncode == 0, done.stderr
        with ground.connect(f"udpout:127.0.0.1:{listen}", timeout_s=30.0, warn=lambda text: None) as kite:
            kite.wait(2.5)
            return json.loads(done.stdout), kite.parameters.get("INNER_P"), kite.armed


@pytest.fixture(scope="module")
def sessions(tmp_path_factory):
    """All sessions at once: they spend their time waiting."""
    folder = tmp_path_factory.mktemp("mavsdk")
    with ThreadPoolExecutor(len(LINKS)) as pool:
        yield {name: pool.submit(fly, link, folder / str(index)) for index, (name, link) in enumerate(LINKS.items())}


@pytest.mark.parametrize("name", LOSSLESS)
def test_everything_succeeds_on_a_link_without_losses(sessions: dict[str, Future], name):
    outcomes, inner_p, armed = sessions[name].result()
    came_of = {call: outcome for call, (outcome, _) in outcomes.items()}
    listed = came_of.pop("list")
    assert set(listed) == set(TABLE)
    assert listed["INNER_P"] == BEFORE
    metadata = came_of.pop("metadata")
    described = {entry["name"]: entry for entry in metadata["parameters"]}
    assert list(described) == list(TABLE)
    for wanted in TABLE.values():
        entry = described[wanted.name]
        assert (entry["shortDesc"], entry.get("units", "")) == (wanted.text, wanted.unit)
        least = 0.0 if wanted.off_at_zero else wanted.least
        assert (entry["min"], entry["max"], entry["default"]) == (least, wanted.greatest, wanted.default)
    assert came_of == {
        "connect": True, "set": "SUCCESS", "get": ASKED, "out of range": "VALUE_OUT_OF_RANGE", "read-only": "READ_ONLY",
        "unknown": "DOES_NOT_EXIST", "version": list(FIRMWARE_VERSION), "disarm first": "SUCCESS",
        "seen disarmed": True, "arm": "SUCCESS", "seen armed": True, "disarm": "SUCCESS", "seen disarmed again": True}
    assert (inner_p, armed) == (ASKED, False)


@pytest.mark.parametrize("name", [name for name in LINKS if name not in LOSSLESS])
def test_every_call_returns_and_nothing_is_half_done_on_a_bad_link(sessions: dict[str, Future], name):
    outcomes, inner_p, armed = sessions[name].result()
    for call, (outcome, took_s) in outcomes.items():
        assert took_s < LIMIT_S, (call, outcome)
    assert inner_p in (BEFORE, ASKED)  # as asked or unchanged, never 1000.0 or anything else
    if outcomes["set"][0] == "SUCCESS":
        assert inner_p == ASKED
    if outcomes["disarm"][0] == "SUCCESS":
        assert not armed
    assert outcomes["out of range"][0] != "SUCCESS"
    assert outcomes["unknown"][0] != "SUCCESS"
