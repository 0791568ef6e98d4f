"""The loop on a board's own clock, simulated: clocks that jump, loops that stand still, ticks that nobody asked for."""

from types import SimpleNamespace
from typing import Any

import pytest
from firmware_bench import sample
from simulated_storage import SimulatedStorage

from firmware_py.autopilot import Autopilot
from firmware_py.boards.interface import POWER_ON, NoLight, NoWatchdog
from firmware_py.loop import run_real_time
from firmware_py.mavlink.link import MavlinkLink
from firmware_py.parameters.generated_parameters import NAMES
from protocol import dialect
from sim_bridge.links.wire import BridgeCodec

SECOND = 1_000_000
PERIOD_US = 20_000
MASK = (1 << 30) - 1


class Board:
    """Time passes while the loop waits. `at` are (time [s], call), `to_firmware` what arrives, a datagram each."""

    sensors = storage = retained = None
    reset_cause = POWER_ON
    actuator: Any = None
    bytes_per_tick = 2048
    datagrams = True

    def __init__(self, start_us: int = 0):
        self.transport = self
        self.watchdog: Any = NoWatchdog()
        self.light = NoLight()
        self.clock_us = start_us
        self.end_us = 0  # of the time that passes
        self.passed_us = 0
        self.at: list[tuple[float, object]] = []
        self.to_firmware: list[bytes] = []
        self.beats: list[float] = []
        self.ticks = 0
        self.said: list[str] = []
        self._parser = dialect.MAVLink(None)

    def ticks_us(self) -> int:
        self._pass(1)
        return self.clock_us & MASK

    def _pass(self, duration_us: int) -> None:
        self.clock_us += duration_us
        self.passed_us += duration_us
        while self.at and self.at[0][0] * SECOND <= self.passed_us:
            self.at.pop(0)[1]()  # type: ignore[operator]

    def ended(self) -> bool:
        return self.passed_us >= self.end_us

    def wait(self, timeout_ms: int) -> bool:
        assert timeout_ms * 1000 <= PERIOD_US
        if self.to_firmware:
            return True
        self._pass(timeout_ms * 1000)
        return bool(self.to_firmware)

    def read(self) -> bytes | None:
        return self.to_firmware.pop(0) if self.to_firmware else None

    def write(self, data: memoryview) -> None:
        for message in self._parser.parse_buffer(bytes(data)) or []:
            if message.get_type() == "HIL_ACTUATOR_CONTROLS":
                self.ticks += 1
            elif message.get_type() == "HEARTBEAT":
                self.beats.append(self.passed_us / SECOND)
            elif isinstance(message, dialect.MAVLink_statustext_message):
                self.said.append(message.text)

    def jump(self, seconds: float) -> None:
        """The clock shows another time from now on."""
        self.clock_us += round(seconds * SECOND)

    def stand_still(self, seconds: float) -> None:
        """The whole process is suspended."""
        self.clock_us += round(seconds * SECOND)
        self.passed_us += round(seconds * SECOND)


def fly(board: Board, seconds: float) -> Autopilot:
    autopilot = Autopilot(MavlinkLink(board))
    board.end_us = round(seconds * SECOND)
    run_real_time(autopilot, board)
    return autopilot


def test_it_keeps_its_beat_and_counts_nothing():
    board = Board()
    autopilot = fly(board, 10.0)
    assert abs(board.ticks - 500) <= 2
    assert autopilot.timing.overruns == 0
    assert board.beats == pytest.approx(range(10), abs=0.03)


@pytest.mark.parametrize("jump_s", [0.5, 5.0, 536.8, 540.0, 700.0, 1070.0, -0.5, -5.0, -530.0])
def test_a_clock_that_jumps_does_not_silence_the_loop(jump_s):
    board = Board(MASK - 3 * SECOND)
    board.at = [(4.0, lambda: board.jump(jump_s))]
    autopilot = fly(board, 10.0)
    assert abs(board.ticks - 500) <= 2
    assert autopilot.timing.overruns == 1


@pytest.mark.parametrize("stop_s", [0.05, 0.9, 5.0, 60.0])
def test_a_loop_that_stood_still_counts_it_and_goes_on_at_its_beat(stop_s):
    board = Board()
    board.at = [(2.0, lambda: board.stand_still(stop_s))]
    autopilot = fly(board, 4.0 + stop_s)
    assert autopilot.timing.overruns == 1
    assert abs(board.ticks - 200) <= 3


def test_a_late_tick_within_a_period_is_caught_up_and_is_none():
    board = Board()
    board.at = [(2.0, lambda: board.stand_still(0.015))]
    autopilot = fly(board, 4.0)
    assert autopilot.timing.overruns == 0
    assert abs(board.ticks - 200) <= 1


def test_a_bridges_tick_changes_nothing_in_real_time():
    """One KITE_TICK, then a sample and five questions each 20 ms: all are taken in by the next tick."""
    board, codec = Board(), BridgeCodec()
    board.to_firmware.append(codec.encode(dialect.MAVLINK_MSG_ID_KITE_TICK, (5, 5)))
    ping = codec.encode_message(dialect.MAVLink_ping_message(1, 2, 0, 0))

    def arrive(tick: int) -> None:
        board.to_firmware += [ping] * 5
        board.to_firmware.append(
            codec.encode(dialect.MAVLINK_MSG_ID_KITE_SENSORS, sample(tick * PERIOD_US, azimuth=0.1 + 1e-4 * tick)))

    board.at = [(0.1 + tick * 0.02, lambda tick=tick: arrive(tick)) for tick in range(200)]
    autopilot = fly(board, 4.3)
    assert not board.to_firmware
    assert autopilot.kite.sample_time == 199 * PERIOD_US
    _, unusable, _, _ = autopilot.link.counters()
    assert unusable == 1


def test_a_board_that_is_too_slow_for_its_rate_is_not_armed():
    """Ticks of 25 ms at 50 Hz; from 4 s on they take 15 ms, and a while later the board may arm."""
    board, codec = Board(), BridgeCodec()
    work = SimpleNamespace(us=25_000)
    board.watchdog = SimpleNamespace(feed=lambda: board._pass(work.us))
    arm = dialect.MAVLink_command_long_message(1, 1, dialect.MAV_CMD_COMPONENT_ARM_DISARM, 0, 1.0, 0, 0, 0, 0, 0, 0)

    def tell(tick: int) -> None:
        told = sample(tick * PERIOD_US, azimuth=0.1 + 1e-4 * tick)
        board.to_firmware.append(codec.encode(dialect.MAVLINK_MSG_ID_KITE_SENSORS, told))

    board.at = sorted(
        [(0.02 * tick, lambda tick=tick: tell(tick)) for tick in range(400)]
        + [(time_s, lambda: board.to_firmware.append(codec.encode_message(arm))) for time_s in (3.0, 6.5)]
        + [(4.0, lambda: setattr(work, "us", 15_000))], key=lambda entry: entry[0])
    autopilot = fly(board, 3.9)
    assert not autopilot.modes.armed()
    assert "loop too slow" in board.said[-1]
    assert autopilot.timing.overruns > 100 and autopilot.timing.worst_us > 25_000
    board.end_us = round(8.0 * SECOND)
    run_real_time(autopilot, board)
    assert autopilot.modes.armed()
    assert autopilot.timing.tick_us < 16_000


def test_a_late_start_is_told():
    board = Board()
    board.at = [(2.0, lambda: board.stand_still(0.013))]
    autopilot = fly(board, 4.0)
    assert 8_000 < autopilot.timing.latest_us <= 13_100
    assert autopilot.timing.overruns == 0


def test_the_tick_that_writes_flash_spoils_no_statistics():
    """A save stalls a board for 0.11 s, on the ground: the loop is not judged by it."""
    board = Board()

    class Flash(SimulatedStorage):
        def write(self, name: str, data: bytes) -> None:
            board._pass(110_000)
            super().write(name, data)

    flash = Flash()
    autopilot = Autopilot(MavlinkLink(board), storage=flash)
    autopilot.parameters.set(NAMES.index(b"INNER_P"), 2.5)
    board.end_us = 3 * SECOND
    run_real_time(autopilot, board)
    assert flash.changes
    assert autopilot.timing.overruns == 0
    assert autopilot.timing.worst_us < PERIOD_US
    assert autopilot.timing.latest_us < PERIOD_US


class Kite:
    """A ground station and a kite on a Board: a sample each 20 ms of the board's time, and commands by name."""

    def __init__(self, board: Board, codec: BridgeCodec):
        self._board, self._codec = board, codec
        self._sent = 0

    def sample(self) -> None:
        self._sent += 1
        told = sample(self._sent * PERIOD_US, azimuth=0.1 + 1e-4 * self._sent)
        self._board.to_firmware.append(self._codec.encode(dialect.MAVLINK_MSG_ID_KITE_SENSORS, told))

    def arm(self, wanted: float) -> None:
        self._board.to_firmware.append(self._codec.encode_message(dialect.MAVLink_command_long_message(
            1, 1, dialect.MAV_CMD_COMPONENT_ARM_DISARM, 0, wanted, 0, 0, 0, 0, 0, 0)))


def flying(seconds: float, **commands: float) -> Board:
    """A board with a kite for so long, and when it is to `arm` and `disarm` [s]."""
    board = Board()
    kite = Kite(board, BridgeCodec())
    board.at = sorted(
        [(0.02 * tick + 0.01, kite.sample) for tick in range(round(50 * seconds))]
        + [(time_s, lambda word=word: kite.arm(float(word == "arm"))) for word, time_s in commands.items()],
        key=lambda entry: entry[0])
    board.end_us = round(seconds * SECOND)
    return board


def test_late_ticks_change_neither_the_age_of_samples_nor_the_way_to_predict():
    """One tick in eight begins 8 ms late: the beat stays, and a sample is one dead time away in each of its ticks."""
    board = flying(6.0, arm=1.0)
    autopilot = Autopilot(MavlinkLink(board))
    autopilot.parameters.set(NAMES.index(b"PRED_DELAY"), 0.2)
    board.at = sorted(board.at + [(2.0 + 0.16 * index, lambda: board.stand_still(0.008)) for index in range(25)],
                      key=lambda entry: entry[0])
    horizons = []
    board.watchdog = SimpleNamespace(
        feed=lambda: horizons.append(autopilot.prediction.horizon_us) if board.passed_us > 3 * SECOND else None)
    run_real_time(autopilot, board)
    assert autopilot.modes.armed() and autopilot.timing.latest_us > 7000
    assert len(horizons) > 140
    assert horizons == pytest.approx([200_000] * len(horizons), abs=500)


def test_steering_leaves_before_what_is_answered_and_told():
    board = flying(3.0, arm=1.0)
    written: list[list[str]] = []
    write, parser = board.write, dialect.MAVLink(None)

    def watched(data: memoryview) -> None:
        written.append([message.get_type() for message in parser.parse_buffer(bytes(data)) or []])
        write(data)

    board.write = watched  # type: ignore[method-assign]
    run_real_time(Autopilot(MavlinkLink(board)), board)
    steering = [kinds for kinds in written if "HIL_ACTUATOR_CONTROLS" in kinds]
    assert len(steering) >= 148
    assert all(kinds == ["HIL_ACTUATOR_CONTROLS"] for kinds in steering)
    assert any("KITE_STATE" in kinds for kinds in written)


def test_a_disarmed_servo_is_neutral_before_its_tick_ends():
    board = flying(4.0, arm=1.0, disarm=3.0)
    servo: list[bool] = []
    board.actuator = SimpleNamespace(write=lambda steering, armed: servo.append(armed))
    autopilot = Autopilot(MavlinkLink(board))
    ended: list[tuple[bool, bool]] = []
    board.watchdog = SimpleNamespace(feed=lambda: ended.append((servo[-1], autopilot.modes.armed())))
    run_real_time(autopilot, board)
    assert {armed for armed, _ in ended} == {True, False}
    assert all(shown == armed for shown, armed in ended)
