"""The firmware as a process: it keeps its own time, and its failures are told in one line."""

import select
import socket
import time

import pytest

from protocol import dialect
from sim_bridge.errors import FirmwareError
from sim_bridge.flight.flight import Flight
from sim_bridge.links.wire import BridgeCodec
from sim_bridge.runs.run import RunOptions, run_scenario
from sim_bridge.runtimes.memory import MemoryRuntime
from sim_bridge.runtimes.process import ProcessRuntime
from sim_bridge.scenario.scenario import load_scenario


def test_in_real_time_the_firmware_flies_on_its_own_clock():
    scenario = load_scenario("paper-delay-tuned")
    scenario.set("run.duration_s", 4.0, "test")
    scenario.set("run.settle_s", 1.0, "test")
    scenario.set_parameter("STALE_TIME", 3.0, "test")  # a busy machine holds either side up; default timing: tests/soak
    result = run_scenario(scenario, RunOptions("cpython", speed=1))
    assert result.real_time and result.numbers["ticks"] == 200
    assert result.numbers["wall_s"] >= 3.9
    assert result.numbers["turning_angle_rms_rad"] < 0.8
    assert result.numbers["steering_rms"] > 0.0


def test_a_firmware_that_dies_in_flight_is_noticed():
    runtime = ProcessRuntime()
    flight = Flight(load_scenario("paper-no-delay"), runtime)
    try:
        runtime.start()
        flight.fly(1.0)
        assert runtime._process
        runtime._process.kill()
        runtime._process.wait()
        with pytest.raises(FirmwareError, match=r"^the firmware ended in tick \d+$"):
            flight.fly(2.0)
    finally:
        runtime.stop()


def test_a_firmware_that_cannot_start_says_its_last_words(monkeypatch):
    runtime = ProcessRuntime()
    monkeypatch.setattr(runtime, "_command", [*runtime._command, "-c", "raise SystemExit('no board here')"])
    try:
        with pytest.raises(FirmwareError, match="ended when it was started: no board here"):
            runtime.start()
    finally:
        runtime.stop()


def test_a_bridge_that_was_suspended_hears_what_the_firmware_said_meanwhile():
    runtime = ProcessRuntime()
    try:
        runtime.start()
        runtime._send(BridgeCodec().encode(dialect.MAVLINK_MSG_ID_KITE_TICK, (1, 0)))
        assert select.select([runtime._socket], [], [], 20.0)[0]
        assert runtime._receive(time.monotonic() - 15.0, "in tick 1")  # the time allowed was slept away
    finally:
        runtime.stop()


def test_a_firmware_whose_bridge_is_gone_does_not_disturb_the_next_on_its_port():
    runtime = ProcessRuntime()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as left_over:
        codec = BridgeCodec()
        heartbeat = codec.encode_message(dialect.MAVLink_heartbeat_message(0, 0, 0, 0, 0, 3))
        other_tick = codec.encode(dialect.MAVLINK_MSG_ID_KITE_TICK_END, (7,))
        try:
            left_over.sendto(heartbeat, runtime._socket.getsockname())
            runtime.start()
            for tick in range(3):
                left_over.sendto(other_tick, runtime._socket.getsockname())
                assert runtime.exchange(tick, 0.02 * tick, [], [], []).steering
        finally:
            runtime.stop()


def test_an_answer_to_another_tick_is_an_error():
    runtime = MemoryRuntime()
    runtime.exchange(1, 0.0, [], [], [])
    runtime._transport.from_firmware.append(BridgeCodec().encode(dialect.MAVLINK_MSG_ID_KITE_TICK_END, (7,)))
    with pytest.raises(FirmwareError, match="ended tick 7 when it was asked for tick 2"):
        runtime.exchange(2, 0.02, [], [], [])
