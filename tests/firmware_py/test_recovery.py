"""A watchdog reset in flight, and every other way of starting: what the kite does, what it remembers, what it says."""

import math
from typing import Any

import pytest
from firmware_bench import NAMES, TICKS_PER_SECOND, Bench, FlyingKite, hovering, of_kind, set_parameter
from simulated_storage import Board, RetainedMemory, SimulatedStorage, flipped, whole_board

from firmware_py.autopilot import Autopilot
from firmware_py.boards.interface import EVENT_MODE, EVENT_RESET, POWER_ON, SOFT, WATCHDOG
from firmware_py.boards.retained_layout import FLIGHT, SIZE
from firmware_py.boards.unix_board import UnixBoard
from firmware_py.mavlink.link import MavlinkLink
from firmware_py.parameters.generated_parameters import COUNT
from firmware_py.parameters.retained import EventRing, Recovery
from firmware_py.parameters.store import SLOTS
from firmware_py.parameters.values import Parameters
from protocol import dialect

STANDBY, PARK, TRACK = dialect.KITE_MODE_STANDBY, dialect.KITE_MODE_PARK, dialect.KITE_MODE_TRACK
ACCEPTED = dialect.MAV_RESULT_ACCEPTED
FLIGHT_BYTES = 17 + 4 * COUNT + 2


def heartbeat_of_a_station() -> dialect.MAVLink_message:
    return dialect.MAVLink_heartbeat_message(dialect.MAV_TYPE_GCS, 8, 0, 0, 0, 3)


def flown_board(kite: FlyingKite) -> Board:
    """A board that flew TRACK and was given gains: one on the ground, which was stored, and one in flight."""
    board = whole_board()
    bench = board.boot(sky=kite)
    bench.set(OUTER_L=4.0)
    bench.run(1.5)
    bench.start(TRACK)
    bench.run(2.0)
    bench.set(INNER_P=2.5)
    assert bench.mode == TRACK
    return board


def fall_without_firmware(kite: FlyingKite, seconds: float) -> None:
    """The kite flies on with neutral steering while the board starts."""
    for tick in range(round(seconds * TICKS_PER_SECOND)):
        kite(tick / TICKS_PER_SECOND, 0.0)


def seconds_until_steered(bench: Bench) -> float:
    """Simulated seconds until the firmware steers again in PARK."""
    for tick in range(5 * TICKS_PER_SECOND):
        bench.step()
        assert bench.autopilot.modes.mode == PARK
        if bench.steering[-1] != 0.0:
            return (tick + 1) / TICKS_PER_SECOND
    raise AssertionError("the kite was never steered")


def last_state(bench: Bench) -> Any:
    return [message for _, message in bench.heard if message.get_type() == "KITE_STATE"][-1]


def storage_of(board: Board) -> SimulatedStorage:
    assert board.storage is not None
    return board.storage


def retained_of(board: Board) -> RetainedMemory:
    assert board.retained is not None
    return board.retained


def flights(board: Board) -> int:
    """How often the flight was written into retained memory."""
    return [offset for offset, _ in retained_of(board).writes].count(FLIGHT)


def assert_on_the_ground(board: Board, cause: str) -> Bench:
    """After a start for `cause` the kite is disarmed, stays so, and has the parameters of its flash."""
    bench = board.boot(cause)
    bench.run(3.0)
    assert bench.mode == STANDBY
    assert set(bench.steering) == {0.0}
    assert (bench.value("OUTER_L"), bench.value("INNER_P")) == (4.0, 1.5)
    return bench


def test_a_watchdog_reset_in_flight():
    kite = FlyingKite()
    board = flown_board(kite)
    fall_without_firmware(kite, 1.0)

    bench = board.boot(WATCHDOG, kite)
    assert seconds_until_steered(bench) <= 2.0
    assert (bench.value("INNER_P"), bench.value("OUTER_L")) == (2.5, 4.0)
    bench.run(3.0)  # it would be at the zenith in three more
    state = last_state(bench)
    assert (state.mode, state.target_course) == (PARK, 0.0)
    assert abs(state.course) < 0.2  # straight up
    assert state.elevation > math.radians(45.0)
    assert bench.texts()[:4] == [
        "reset: watchdog", "parameters restored after the reset", "back after a reset: PARK",
        "samples fresh again: PARK"]
    severities = {message.text: message.severity for message in of_kind("STATUSTEXT", [m for _, m in bench.heard])}
    assert severities["back after a reset: PARK"] == dialect.MAV_SEVERITY_CRITICAL

    assert bench.change_mode(TRACK) == ACCEPTED
    bench.run(1.0)
    assert bench.mode == TRACK


def test_while_no_samples_arrive_it_waits_armed_and_neutral():
    kite = FlyingKite()
    bench = flown_board(kite).boot(WATCHDOG)
    bench.sky = None
    bench.run(5.0)
    assert set(bench.steering) == {0.0}
    beats = [m for _, m in bench.heard if m.get_type() == "HEARTBEAT"]
    assert {(m.custom_mode, m.system_status) for m in beats} == {(PARK, dialect.MAV_STATE_CRITICAL)}
    assert all(m.base_mode & dialect.MAV_MODE_FLAG_SAFETY_ARMED for m in beats)
    bench.sky = kite
    assert seconds_until_steered(bench) <= 2.0


def test_an_operator_may_disarm_before_samples_are_back():
    board = flown_board(FlyingKite())
    bench = board.boot(WATCHDOG)
    bench.sky = None
    bench.run(1.0)
    assert bench.disarm() == ACCEPTED
    bench.sky = hovering()
    bench.run(3.0)
    assert bench.mode == STANDBY
    assert board.boot(WATCHDOG).autopilot.modes.mode == STANDBY


@pytest.mark.parametrize("before_samples", [True, False])
def test_a_second_reset_right_after_the_first(before_samples):
    kite = FlyingKite()
    board = flown_board(kite)
    first = board.boot(WATCHDOG, kite)
    if before_samples:
        first.sky = None
        first.run(0.2)
    else:
        seconds_until_steered(first)
    bench = board.boot(WATCHDOG, kite)
    assert seconds_until_steered(bench) <= 2.0
    assert bench.value("INNER_P") == 2.5


def test_a_curve_that_cannot_be_flown_does_not_keep_it_from_parking():
    board = whole_board()
    bench = board.boot(sky=hovering())
    bench.start(PARK)
    bench.set(EIGHT_ELEVATION=80.0)
    bench = board.boot(WATCHDOG)
    assert seconds_until_steered(bench) <= 2.0
    assert bench.value("EIGHT_ELEVATION") == 80.0


def test_it_comes_back_in_park_even_where_track_may_resume():
    kite = FlyingKite()
    board = flown_board(kite)
    bench = board.boot(WATCHDOG, kite)
    bench.set(RESUME_TRACK=1.0)
    bench = board.boot(WATCHDOG, kite)
    assert bench.value("RESUME_TRACK") == 1.0
    bench.run(2.0)
    assert bench.mode == PARK


@pytest.mark.parametrize("cause", [POWER_ON, SOFT])
def test_any_other_start_is_disarmed_with_the_stored_parameters(cause):
    bench = assert_on_the_ground(flown_board(FlyingKite()), cause)
    assert bench.texts() == [f"reset: {cause}", f"{COUNT - 1} parameters from storage"]


@pytest.mark.parametrize("cause", [POWER_ON, SOFT])
def test_a_watchdog_reset_during_such_a_start_does_not_bring_the_old_flight_back(cause):
    board = flown_board(FlyingKite())
    board.boot(cause)  # hangs before its first tick
    bench = board.boot(WATCHDOG)
    bench.run(3.0)
    assert bench.mode == STANDBY
    assert bench.value("INNER_P") == 1.5


def test_spoilt_memory_after_a_watchdog_reset_at_any_byte():
    board = flown_board(FlyingKite())
    whole = retained_of(board).data
    for position in range(FLIGHT, FLIGHT + FLIGHT_BYTES):
        retained_of(board).data = flipped(whole, position, 0x10)
        bench = board.boot(WATCHDOG)
        assert bench.autopilot.modes.mode == STANDBY, position
        assert (bench.value("OUTER_L"), bench.value("INNER_P")) == (4.0, 1.5)
    retained_of(board).data = flipped(whole, FLIGHT + FLIGHT_BYTES)  # not the flight's
    assert board.boot(WATCHDOG).autopilot.modes.mode == PARK


@pytest.mark.parametrize("data", [bytes(SIZE), b"\xff" * SIZE, bytes(range(256)) * 3])
def test_memory_with_nothing_in_it(data):
    board = flown_board(FlyingKite())
    retained_of(board).data = data
    bench = assert_on_the_ground(board, WATCHDOG)
    assert bench.texts()[:2] == ["reset: watchdog", "nothing retained from before the reset"]


def test_memory_of_another_contract_is_not_read(monkeypatch):
    board = flown_board(FlyingKite())
    monkeypatch.setattr("firmware_py.parameters.retained._CONTRACT", b"0123456789abcdef")
    assert_on_the_ground(board, WATCHDOG)


def test_a_board_without_retained_memory_comes_back_disarmed():
    board = flown_board(FlyingKite())
    board.retained = None
    assert assert_on_the_ground(board, WATCHDOG).texts()[0] == "reset: watchdog"


def test_a_board_with_nothing_but_retained_memory():
    board = Board(None, RetainedMemory())
    bench = board.boot()
    bench.start(PARK)
    bench.set(INNER_P=2.5)
    bench = board.boot(WATCHDOG)
    assert seconds_until_steered(bench) <= 2.0
    assert bench.value("INNER_P") == 2.5
    assert board.boot(POWER_ON).value("INNER_P") == 1.5


def test_a_watchdog_reset_on_the_ground_keeps_what_was_not_stored_yet():
    board = whole_board()
    board.boot().set(INNER_P=2.5)
    bench = board.boot(WATCHDOG)
    bench.run(2.0)
    assert bench.mode == STANDBY
    assert board.boot(POWER_ON).value("INNER_P") == 2.5


def test_flash_is_not_written_in_flight_and_is_after_disarming():
    board = whole_board()
    storage = storage_of(board)
    bench = board.boot(sky=FlyingKite())
    bench.set(OUTER_L=4.0)
    assert storage.changes == []
    bench.start(TRACK)  # within the second in which it would have been written
    for step in range(20):
        bench.set(INNER_P=2.0 + step / 32)
        bench.run(0.5)
    assert storage.changes == []
    bench.disarm()
    bench.run(0.9)
    assert storage.changes == []
    bench.run(0.2)
    assert [operation for operation, _ in storage.changes] == ["write", "rename"]
    assert "parameters saved" in bench.texts()
    bench.run(20.0)
    assert len(storage.changes) == 2
    again = board.boot(POWER_ON)
    assert (again.value("OUTER_L"), again.value("INNER_P")) == (4.0, 2.59375)


def test_what_came_back_after_a_reset_is_stored_after_disarming():
    kite = FlyingKite()
    board = flown_board(kite)
    changes = len(storage_of(board).changes)
    bench = board.boot(WATCHDOG, kite)
    bench.run(5.0)
    assert len(storage_of(board).changes) == changes
    bench.disarm()
    bench.run(1.1)
    assert len(storage_of(board).changes) == changes + 2
    assert board.boot(POWER_ON).value("INNER_P") == 2.5


def test_a_set_of_gains_is_stored_once_when_the_last_has_come():
    board = whole_board()
    bench = board.boot()
    for index, name in enumerate(("INNER_P", "OUTER_L", "TURN_K", "STEER_MAX")):
        bench.set(**{name: 0.5 + index / 8})
        bench.run(0.8)
    assert storage_of(board).changes == []
    bench.run(0.5)
    assert len(storage_of(board).changes) == 2


def test_storage_that_fails_is_tried_again_with_the_next_change_only():
    board = whole_board()
    bench = board.boot()
    storage_of(board).full = True
    bench.set(INNER_P=2.5)
    bench.run(5.0)
    assert [text for text in bench.texts() if "save" in text] == ["parameters not saved: storage failed"]
    assert bench.autopilot.keeper.storage_fails()
    storage_of(board).full = False
    bench.set(OUTER_L=3.0)
    bench.run(1.2)
    assert not bench.autopilot.keeper.storage_fails()
    assert board.boot(POWER_ON).value("INNER_P") == 2.5


def test_slots_that_are_both_spoilt_count_as_storage_that_fails_until_a_save():
    board = whole_board()
    storage_of(board).files.update(dict.fromkeys(SLOTS, b"noise"))
    bench = board.boot()
    assert bench.autopilot.keeper.storage_fails()
    bench.set(INNER_P=2.5)
    bench.run(1.2)
    assert "2 of 2 parameter slots damaged" in bench.texts()
    assert not bench.autopilot.keeper.storage_fails()
    assert board.boot(POWER_ON).value("INNER_P") == 2.5


def test_retained_memory_is_written_on_a_change_only():
    board = whole_board()
    bench = board.boot(sky=FlyingKite())
    bench.start(TRACK)
    writes = flights(board)
    bench.run(10.0)
    assert flights(board) == writes
    bench.ask(set_parameter("INNER_P", 2.0), set_parameter("OUTER_L", 4.0))
    assert flights(board) == writes + 1
    bench.disarm()
    assert flights(board) == writes + 2


def test_resets_and_modes_are_events_that_outlive_a_reset():
    board = flown_board(FlyingKite())
    board.boot(WATCHDOG, FlyingKite()).run(0.1)
    events = [(code, value) for _, code, _, value in EventRing(retained_of(board)).entries()]
    assert events == [(EVENT_RESET, 0.0), (EVENT_MODE, float(PARK)), (EVENT_MODE, float(TRACK)),
                      (EVENT_RESET, 1.0), (EVENT_MODE, float(PARK))]
    uptimes_ms = [uptime for _, _, uptime, _ in EventRing(retained_of(board)).entries()]
    assert uptimes_ms[0] == uptimes_ms[3] == 0 and 1500 < uptimes_ms[1] < uptimes_ms[2] < 4500


def test_a_value_that_was_acknowledged_has_been_kept():
    board = whole_board()
    bench = board.boot()
    bench.start(PARK)
    for name in ("INNER_P", "FF_GAIN", "STATE_HZ", "PARK_ELEVATION"):
        bench.set(**{name: 0.75})
        kept = Parameters()
        assert Recovery(retained_of(board)).load(kept) is True
        assert kept.values == bench.autopilot.parameters.values
        assert kept.values[NAMES.index(name)] == 0.75


def test_a_system_id_of_its_own_counts_from_the_first_frame():
    board = whole_board()
    bench = board.boot()
    bench.set(SYSTEM_ID=7.0, LOOP_HZ=100.0)
    bench.run(1.2)
    bench = board.boot(POWER_ON)
    bench.step()
    assert {message.get_srcSystem() for _, message in bench.heard} == {7}
    assert bench.autopilot.period_us == 10000


def test_a_station_that_comes_later_is_told_once_what_happened():
    bench = flown_board(FlyingKite()).boot(WATCHDOG)
    bench.run(10.0)
    heard = []
    for _ in range(3):
        bench.heard.clear()
        bench.tell(heartbeat_of_a_station())
        bench.run(1.0)
        heard.append(bench.texts())
    assert heard == [["reset: watchdog", "parameters restored after the reset"], [], []]
    bench._waiting.append(heartbeat_of_a_station().pack(dialect.MAVLink(None, 254, 190)))
    bench.run(1.0)
    assert bench.texts() == heard[0]  # another one is told, too


def test_more_stations_than_are_counted():
    bench = whole_board().boot()
    keeper = bench.autopilot.keeper
    bench.run(1.0)
    bench.heard.clear()
    for system in range(1, 100):
        keeper.greet(system)
        bench.run(0.1)
    assert bench.texts().count("reset: power-on") == 8


class QuietTransport:
    """Nobody is there."""

    datagrams = True

    def read(self) -> None:
        return None

    def write(self, data: memoryview) -> None:
        pass

    def wait(self, timeout_ms: int) -> bool:
        return False


def test_a_pc_keeps_its_parameters_in_a_folder(tmp_path):
    def start() -> Autopilot:
        board = UnixBoard(QuietTransport(), 1000, str(tmp_path / "kite"))
        return Autopilot(MavlinkLink(board.transport), False, board.storage, board.retained, board.reset_cause)

    autopilot = start()
    autopilot.parameters.set(NAMES.index("INNER_P"), 2.5)
    for tick in range(60):
        autopilot.tick(tick * 20000)
    assert start().parameters.values[NAMES.index("INNER_P")] == 2.5
    assert UnixBoard(QuietTransport(), 1000).storage is None


def test_a_bench_without_storage_or_retained_memory_says_and_keeps_nothing():
    bench = Bench()
    bench.tell(heartbeat_of_a_station())
    bench.set(INNER_P=2.5)
    bench.run(3.0)
    assert bench.texts() == []
