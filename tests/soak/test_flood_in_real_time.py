"""A flood while the firmware, a process of its own, flies in real time: heartbeats, the age of the steering, DISARM."""

import random
import socket
import subprocess
import sys
import threading
import time
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from kite_analysis.flights.tlog import read_tlog
from protocol import dialect

pytestmark = pytest.mark.soak

FLOWN_S = 20.0
PACKETS_A_SECOND = 2000
BATCH_S = 0.01


class Heard(NamedTuple):
    """Times of heartbeats on the ground [s], how long DISARM took from the firmware's input to its state, ages [s]."""

    beats: list[float]
    disarm_took_s: float
    ages_s: list[float]


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def datagram(system: int, message: dialect.MAVLink_message) -> bytes:
    return message.pack(dialect.MAVLink(None, system, 190))


def command(number: int, first: float = 0.0, second: float = 0.0, system: int = 1) -> dialect.MAVLink_message:
    return dialect.MAVLink_command_long_message(system, 1, number, 0, first, second, 0.0, 0.0, 0.0, 0.0, 0.0)


def worst_kind() -> list[bytes]:
    """A hundredth of a second's worth, many times over: PARKs for another system, spoofed ids, questions."""
    dice = random.Random(3)
    packets = []
    for _ in range(1000):
        spoofed = dice.randrange(2, 250)
        packets += [datagram(66, command(dialect.MAV_CMD_DO_SET_MODE, 1.0, dialect.KITE_MODE_PARK, 2)),
                    datagram(spoofed, command(dialect.MAV_CMD_REQUEST_MESSAGE, 435.0)),
                    datagram(spoofed, command(dice.randrange(600, 3000))),
                    datagram(spoofed, dialect.MAVLink_ping_message(1, 2, 0, 0))]
    return packets


def pour(address: tuple[str, int], over: threading.Event) -> None:
    """PACKETS_A_SECOND, and one list of parameters a second, until it is over."""
    packets, sent = worst_kind(), 0
    ask = datagram(77, dialect.MAVLink_param_request_list_message(1, 1))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as attacker:
        started = time.monotonic()
        while not over.wait(BATCH_S):
            while sent < (time.monotonic() - started) * PACKETS_A_SECOND:
                attacker.sendto(packets[sent % len(packets)], address)
                sent += 1
                if sent % PACKETS_A_SECOND == 0:
                    attacker.sendto(ask, address)


def listen(station: socket.socket, address: tuple[str, int]) -> tuple[list[float], float]:
    """Send a station's heartbeats for FLOWN_S, then disarm until that is seen.

    Return when the kite's heartbeats came [s], and how long the first state in STANDBY took to come [s].
    """
    parser = dialect.MAVLink(None)
    parser.robust_parsing = True
    beats: list[float] = []
    sent_s, next_s = 0.0, 0.0
    started = None
    end = time.monotonic() + FLOWN_S + 60.0
    while (now := time.monotonic()) < end:
        if now >= next_s:
            next_s = now + 1.0
            station.sendto(datagram(255, dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)), address)
        try:
            data = station.recv(4096)
        except TimeoutError:
            continue
        for message in parser.parse_buffer(data) or []:
            kind: Any = message
            if message.get_type() == "HEARTBEAT":
                beats.append(time.monotonic())
                started = started or beats[0]
            elif message.get_type() == "KITE_STATE" and sent_s and kind.mode == dialect.KITE_MODE_STANDBY:
                return beats, time.monotonic() - sent_s
        if started and not sent_s and time.monotonic() - started > FLOWN_S:
            sent_s = time.monotonic()
            station.sendto(datagram(255, command(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 0.0)), address)
    raise AssertionError(f"no STANDBY; {len(beats)} heartbeats")


def fly(folder: Path, flooded: bool) -> Heard:
    send_to, port = free_port(), free_port()
    log = folder / ("flooded" if flooded else "quiet")
    address = ("127.0.0.1", port)
    process = subprocess.Popen(
        [sys.executable, "-m", "sim_bridge.cli.main", "run", "small-kite", "--runtime", "cpython", "--speed", "1",
         "--ground", "--duration", str(FLOWN_S + 4.0), "--log", str(log),
         "--set", f"ground.send_to=127.0.0.1:{send_to}",
         "--set", f"ground.listen=127.0.0.1:{port}", "--set", "link.ground.up.rate_bytes_s=5760"],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    over = threading.Event()
    attack = threading.Thread(target=pour, args=(address, over))
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as station:
            station.bind(("127.0.0.1", send_to))
            station.settimeout(60.0)
            station.recv(4096)
            station.settimeout(0.05)
            if flooded:
                attack.start()
            beats, disarm_took_s = listen(station, address)
    finally:
        over.set()
        if flooded and attack.is_alive():
            attack.join()
        process.wait(60.0)
    return Heard(beats, disarm_took_s, steering_ages(log / "control.tlog"))


def steering_ages(path: Path) -> list[float]:
    """How long after the newest sample steering came, each time, on the bridge's clock [s]."""
    ages, sample_us = [], None
    for time_us, frame in read_tlog(path):
        number = int.from_bytes(frame[7:10], "little")
        if number == dialect.MAVLINK_MSG_ID_KITE_SENSORS:
            sample_us = time_us
        elif number == dialect.MAVLINK_MSG_ID_HIL_ACTUATOR_CONTROLS and sample_us is not None:
            ages.append((time_us - sample_us) * 1e-6)
    return ages


def at_99_percent(values: list[float]) -> float:
    return sorted(values)[int(0.99 * len(values))]


def test_heartbeats_steering_and_disarm_go_on_as_without_it(tmp_path):
    quiet, flooded = fly(tmp_path, False), fly(tmp_path, True)
    for heard in (quiet, flooded):
        assert len(heard.beats) >= FLOWN_S - 1
        assert max(later - before for before, later in pairwise(heard.beats)) < 1.7
        assert heard.disarm_took_s < 0.2
    assert at_99_percent(flooded.ages_s) < at_99_percent(quiet.ages_s) + 0.010
