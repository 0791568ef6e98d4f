"""Hardware in the loop without hardware: the firmware at the far end of a pseudo-terminal, as a board on a cable."""

import os
import pty
import select
import socket
import subprocess
import sys
import threading
import time
import tty
from pathlib import Path

import pytest

import firmware_py
from protocol import dialect
from sim_bridge.errors import ScenarioError
from sim_bridge.flight.flight import Flight
from sim_bridge.flight.truth_columns import COLUMNS
from sim_bridge.links.port import open_port
from sim_bridge.runs.hardware_in_the_loop import board_report, delay_problem, fly_board, link_warnings
from sim_bridge.runs.run import RunOptions
from sim_bridge.runtimes.inproc import InprocRuntime
from sim_bridge.runtimes.interpreter import find_interpreter, micropython_command
from sim_bridge.runtimes.process import micropython_and_firmware
from sim_bridge.runtimes.tick_output import clock_us
from sim_bridge.scenario.scenario import load_scenario

BAUD = 115200


class Cable:
    """Two pseudo-terminals joined by threads that pass bytes on no faster than a serial cable of BAUD does.

    `ends` are paths that stay the same when the bridge's end is pulled out and plugged in again.
    """

    def __init__(self, folder):
        self.ends = [folder / "bridge", folder / "board"]
        self._pairs = [self._plug(end) for end in self.ends]
        self._start()

    def unplug(self):
        """Pull the bridge's end out."""
        self._stop()
        self.ends[0].unlink()
        for end in self._pairs[0]:
            os.close(end)

    def plug_in(self):
        """Plug it in again: a new device under the old name."""
        self._pairs[0] = self._plug(self.ends[0])
        self._start()

    def close(self):
        self._stop()
        for pair in self._pairs:
            for end in pair:
                os.close(end)

    def _plug(self, path):
        pair = pty.openpty()
        for end in pair:
            tty.setraw(end)
        os.set_blocking(pair[0], False)  # what nobody reads is lost, as on any cable
        path.symlink_to(os.ttyname(pair[1]))
        return pair

    def _start(self):
        masters = [pair[0] for pair in self._pairs]
        self._carries = True
        self._threads = [
            threading.Thread(target=self._carry, args=ends, daemon=True) for ends in (masters, masters[::-1])]
        for thread in self._threads:
            thread.start()

    def _stop(self):
        """Let go of the ends before they are closed: their numbers are soon somebody else's."""
        self._carries = False
        for thread in self._threads:
            thread.join()

    def _carry(self, source, target):
        while self._carries:
            if not select.select([source], [], [], 0.05)[0]:
                continue
            try:
                data = os.read(source, 64)
                time.sleep(len(data) * 10 / BAUD)
                os.write(target, data)
            except OSError:  # nobody has the other end open yet
                time.sleep(0.05)


@pytest.fixture
def cable(tmp_path):
    cable = Cable(tmp_path)
    yield cable
    cable.close()


def firmware_on(device, interpreter, host="serial"):
    command, folder = [sys.executable], Path(firmware_py.__file__).parent.parent
    if interpreter == "micropython":
        command, folder = micropython_and_firmware(find_interpreter())
    return subprocess.Popen([*command, "-m", "firmware_py.main", host, device, "realtime"], cwd=folder)


@pytest.mark.parametrize("interpreter", ["micropython", "cpython"])
def test_a_board_on_a_cable_tracks_the_eight_and_its_own_delay_is_measured(cable, interpreter):
    if interpreter == "micropython" and not micropython_command():
        pytest.skip("no MicroPython interpreter on this platform")
    scenario = load_scenario("paper-delay-tuned")
    scenario.set("run.duration_s", 12.0, "test")
    scenario.set("run.settle_s", 2.0, "test")
    scenario.set_parameter("STALE_TIME", 3.0, "test")  # a busy machine holds either side up; default timing: tests/soak
    said = []
    board = firmware_on(str(cable.ends[1]), interpreter)
    try:
        result, measured = fly_board(scenario, f"serial:{cable.ends[0]}:{BAUD}", RunOptions("hil", 1.0), said.append)
    finally:
        board.kill()
        board.wait()
    assert result.numbers["verdict"] == "tracking" and result.numbers["ticks"] == 600
    assert result.numbers["cross_track_rms_rad"] < 0.12
    # At least the bytes of sample, steering and state on the cable, and half a period's wait for the board's tick.
    assert 0.008 < measured["board_delay_s"] < 0.1
    assert measured["delay_emulated_s"] == pytest.approx(0.2 - measured["board_delay_s"], abs=0.005)
    assert measured["delay_flown_s"] == measured["delay_emulated_s"] + measured["board_delay_s"]


def test_a_board_on_the_network_is_answered_where_it_sends_to():
    scenario = load_scenario("paper-delay-tuned")
    scenario.set("run.duration_s", 3.0, "test")
    scenario.set("run.settle_s", 1.0, "test")
    scenario.set_parameter("STALE_TIME", 3.0, "test")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    board = firmware_on(str(port), "cpython", "127.0.0.1")
    try:
        result, _ = fly_board(scenario, f"udp:127.0.0.1:{port}", RunOptions("hil", 1.0), print)
    finally:
        board.kill()
        board.wait()
    assert result.numbers["ticks"] == 150 and result.numbers["steering_rms"] > 0.0
    assert {row[COLUMNS.index("mode")] for row in result.flight.rows} == {dialect.KITE_MODE_TRACK}


def test_an_unplugged_board_parks_and_the_flight_goes_on_when_it_is_back(cable):
    """Fly, pull the plug, wait for the fail-safe, plug in: the board is in PARK and the bridge has said what it saw."""
    scenario = load_scenario("paper-delay-tuned")
    scenario.set("run.duration_s", 10.0, "test")
    scenario.set_parameter("STALE_TIME", 1.0, "test")
    said = []

    def pull_and_plug(flight):
        second = round(flight.time_s)
        if second == 3:
            cable.unplug()
        elif second == 5:
            cable.plug_in()

    board = firmware_on(str(cable.ends[1]), "cpython")
    try:
        result, _ = fly_board(
            scenario, f"serial:{cable.ends[0]}:{BAUD}", RunOptions("hil", 1.0, on_second=pull_and_plug), said.append)
    finally:
        board.kill()
        board.wait()
    mode, time_s = COLUMNS.index("mode"), COLUMNS.index("time_s")
    rows = result.flight.rows
    assert {row[mode] for row in rows if 1.0 < row[time_s] < 2.9} == {dialect.KITE_MODE_TRACK}
    assert {row[mode] for row in rows if row[time_s] > 8.5} == {dialect.KITE_MODE_PARK}
    assert "disconnected" in said[0] and "connected again" in said[1] and len(said) == 2


class LateBoard(InprocRuntime):
    """A board in simulated time that takes `delay_s` [s] from a sample to the steering it makes of it.

    It steers by the number of the sample, so that what is felt tells how old it is.
    """

    def __init__(self, delay_s: float):
        super().__init__()
        self._delay_s = delay_s

    def exchange(self, tick, time_s, samples, requests, datagrams):
        output = super().exchange(tick, time_s, samples, requests, datagrams)
        output.steering = [(time_s + self._delay_s, float(sample[0])) for sample in samples]
        return output


def delay_flown(flight: Flight) -> float:
    """From the newest sample that the actuator feels to that moment [s], by what it was asked for and when."""
    felt: list[tuple[float, float]] = []
    take = flight.actuator.command

    def note(time_s, steering):
        felt.append((time_s, steering))
        take(time_s, 0.0)

    flight.actuator.command = note  # type: ignore[method-assign]
    flight.fly(flight.time_s + 1.0)
    ages = {round(time_s - flight_s(int(stamp)), 6) for time_s, stamp in felt[-20:]}
    assert len(ages) == 1
    return ages.pop()


def flight_s(stamp_us: int) -> float:
    """Time of the flight at a stamp of the firmware's clock [s]."""
    return ((stamp_us - clock_us(0.0) + (1 << 29)) % (1 << 30) - (1 << 29)) * 1e-6


@pytest.mark.parametrize("loop_hz", [50.0, 20.0, 200.0])
@pytest.mark.parametrize(("board_ms", "links", "asked_ms", "flown_ms"), [
    (40, {"delay_s": 0.05}, 50, 50),  # more than the whole of the steering's part
    (12, {"delay_s": 0.05}, 50, 50), (40, {"delay_s": 0.2}, 200, 200), (12, {"delay_s": 0.0}, 0, 12),
    (40, {"delay_s": 0.03}, 30, 40),  # cannot be reached
    (40, {"down.delay_s": 0.2, "up.delay_s": 0.0}, 200, 200), (40, {"down.delay_s": 0.0, "up.delay_s": 0.1}, 100, 100),
    (7, {"down.delay_s": 0.033, "up.delay_s": 0.001}, 34, 34)])
def test_what_the_board_takes_itself_is_left_out_of_the_emulated_delay(board_ms, links, asked_ms, flown_ms, loop_hz):
    scenario = load_scenario("paper-no-delay")
    scenario.set_parameter("LOOP_HZ", loop_hz, "test")
    for key, value in links.items():
        scenario.set(f"link.control.{key}", value, "test")
    flight = Flight(scenario, LateBoard(0.001 * board_ms))
    flight.allow_for(0.001 * board_ms)
    assert 1000.0 * delay_flown(flight) == pytest.approx(flown_ms, abs=0.01)
    report = board_report(flight, (0.001 * board_ms, 0.0))
    assert 1000.0 * report["delay_asked_s"] == pytest.approx(asked_ms)
    assert 1000.0 * report["delay_flown_s"] == pytest.approx(flown_ms)
    assert 1000.0 * report["delay_emulated_s"] == pytest.approx(flown_ms - board_ms)
    problem = delay_problem(report)
    if flown_ms == asked_ms:
        assert problem is None
    else:
        assert problem and f"takes {board_ms} ms, more than the {asked_ms} ms" in problem


def test_a_board_whose_delay_cannot_be_measured_is_told():
    flight = Flight(load_scenario("paper-delay"), LateBoard(0.04))
    report = board_report(flight, None)
    assert report["delay_flown_s"] is None and report["delay_emulated_s"] == pytest.approx(0.2)
    assert "200 ms requested were emulated on top" in (delay_problem(report) or "")


def test_a_link_that_is_too_slow_is_said_beforehand_with_what_would_help():
    scenario = load_scenario("small-kite")
    assert link_warnings(scenario, 11520.0) == []
    slow = link_warnings(scenario, 5760.0)
    assert len(slow) == 1 and "STATE_HZ=" in slow[0]
    assert len(link_warnings(scenario, 960.0)) == 2


@pytest.mark.parametrize(("link", "says"), [
    ("serial:/dev/no-such-port:115200", "/dev/no-such-port"), ("serial:x", "must be serial:DEVICE:BAUD"),
    ("udp:host", "is not HOST:PORT"), ("usb:1", "must be serial:DEVICE:BAUD or udp:HOST:PORT"),
])
def test_a_wrong_link_is_one_line(link, says):
    with pytest.raises(ScenarioError, match=says) as error:
        open_port(link, print)
    assert "\n" not in str(error.value)


def test_a_silent_board_is_told_with_what_to_check(cable, monkeypatch):
    monkeypatch.setattr("sim_bridge.runs.hardware_in_the_loop.HilRuntime.__init__.__defaults__", (0.3, time.monotonic))
    with pytest.raises(Exception, match=r"no message from the board for 0.3 s: is it powered"):
        fly_board(load_scenario("small-kite"), f"serial:{cable.ends[0]}:{BAUD}", RunOptions("hil", 1.0), print)
