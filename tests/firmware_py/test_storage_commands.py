"""MAV_CMD_PREFLIGHT_STORAGE over the wire."""

import math

import pytest
from firmware_bench import NAMES, Bench, hovering
from simulated_storage import Board, RetainedMemory, SimulatedStorage, whole_board

from firmware_py.boards.interface import POWER_ON, WATCHDOG
from protocol import dialect
from protocol.parameter_table import load_parameters

STORAGE = dialect.MAV_CMD_PREFLIGHT_STORAGE
READ, WRITE, RESET = 0.0, 1.0, 2.0
ACCEPTED = dialect.MAV_RESULT_ACCEPTED
REJECTED = dialect.MAV_RESULT_TEMPORARILY_REJECTED
FAILED = dialect.MAV_RESULT_FAILED
TABLE = load_parameters()
DEFAULTS = [entry.default for entry in TABLE.values()]


def announced(bench: Bench) -> dict[str, float]:
    """PARAM_VALUEs since the texts were read, with half a second for those that wait; never more than six in a tick."""
    bench.run(0.5)
    heard = [(time_s, message) for time_s, message in bench.heard if message.get_type() == "PARAM_VALUE"]
    times = [time_s for time_s, _ in heard]
    assert all(times.count(time_s) <= 6 for time_s in times)
    return {message.param_id: message.param_value for _, message in heard}


def said(bench: Bench) -> list[str]:
    """Texts since the last time, with half a second for those that wait."""
    bench.run(0.5)
    texts = bench.texts()
    bench.heard.clear()
    return texts


@pytest.fixture
def board() -> Board:
    """A board with storage, where two gains have been stored."""
    board = whole_board()
    bench = board.boot()
    bench.set(INNER_P=2.5, OUTER_L=3.0)
    bench.run(1.2)
    return board


@pytest.fixture
def bench(board) -> Bench:
    bench = board.boot()
    said(bench)
    return bench


def test_write_stores_at_once(bench, board):
    bench.set(INNER_P=7.0)
    assert bench.command(STORAGE, WRITE) == ACCEPTED
    assert board.boot(POWER_ON).value("INNER_P") == 7.0
    assert said(bench) == ["parameters saved"]


def test_a_copy_of_the_command_writes_nothing(bench, board):
    bench.set(INNER_P=7.0)
    assert bench.command(STORAGE, WRITE) == ACCEPTED
    done = len(board.storage.changes)
    assert bench.command(STORAGE, WRITE) == ACCEPTED
    bench.run(3.0)
    assert len(board.storage.changes) == done


def test_read_takes_back_what_is_stored_and_announces_what_that_changed(bench, board):
    bench.set(INNER_P=7.0, TURN_K=1.0)
    bench.heard.clear()
    assert bench.command(STORAGE, READ) == ACCEPTED
    assert announced(bench) == {"INNER_P": 2.5, "TURN_K": 0.25}
    assert said(bench) == [f"{len(NAMES) - 1} parameters from storage"]
    done = len(board.storage.changes)
    bench.run(3.0)
    assert len(board.storage.changes) == done  # nothing is left to save
    assert (bench.value("INNER_P"), bench.value("OUTER_L"), bench.value("TURN_K")) == (2.5, 3.0, 0.25)


def test_reset_goes_back_to_the_defaults_and_stores_them(bench, board):
    assert bench.command(STORAGE, RESET) == ACCEPTED
    assert announced(bench) == {"INNER_P": 1.5, "OUTER_L": 5.0}
    assert bench.autopilot.parameters.values == DEFAULTS
    assert board.boot(POWER_ON).autopilot.parameters.values == DEFAULTS
    assert said(bench) == ["parameters saved"]
    bench.run(3.0)
    assert said(bench) == []


def test_however_many_have_changed_six_are_announced_in_a_tick(bench):
    wanted = {name: entry.greatest for name, entry in TABLE.items() if entry.greatest != entry.default}
    for name in ("SYSTEM_ID", "TABLE_VERSION"):
        del wanted[name]
    bench.set(**wanted)
    assert len(wanted) > 20
    bench.heard.clear()
    assert bench.command(STORAGE, RESET) == ACCEPTED
    assert announced(bench) == {name: TABLE[name].default for name in wanted}


def test_a_list_under_way_is_not_cut_short_by_what_is_announced(bench):
    bench.tell(dialect.MAVLink_param_request_list_message(1, 1))
    bench.step()
    assert bench.command(STORAGE, RESET) == ACCEPTED
    bench.run(1.0)
    listed = [message.param_index for _, message in bench.heard if message.get_type() == "PARAM_VALUE"]
    assert sorted(set(listed)) == list(range(len(NAMES)))
    assert {NAMES[index] for index in listed if listed.count(index) > 1} <= {"INNER_P", "OUTER_L"}


def test_values_that_were_read_or_reset_outlive_a_watchdog_reset(bench, board):
    bench.set(INNER_P=7.0)
    bench.command(STORAGE, READ)
    assert board.boot(WATCHDOG).value("INNER_P") == 2.5
    bench.command(STORAGE, RESET)
    assert board.boot(WATCHDOG).value("INNER_P") == 1.5


@pytest.mark.parametrize("action", [READ, WRITE, RESET])
def test_refused_while_armed(bench, board, action):
    bench.start(dialect.KITE_MODE_TRACK)
    bench.set(INNER_P=7.0)
    before = list(bench.autopilot.parameters.values)
    done = len(board.storage.log)
    assert bench.command(STORAGE, action) == REJECTED
    assert said(bench) == ["disarm first"]
    assert bench.autopilot.parameters.values == before
    assert len(board.storage.log) == done  # not even looked at


@pytest.mark.parametrize("action", [READ, WRITE, RESET])
@pytest.mark.parametrize("bare", [Board(), Board(None, RetainedMemory())])
def test_refused_where_there_is_no_storage(bare, action):
    bench = bare.boot(sky=hovering())
    said(bench)
    bench.set(INNER_P=7.0)
    assert bench.command(STORAGE, action) == REJECTED
    assert said(bench) == ["no storage on this board"]
    assert bench.value("INNER_P") == 7.0


@pytest.mark.parametrize("action", [-1.0, 0.5, 3.0, 4.0, math.nan, math.inf])
def test_other_actions_are_denied(bench, board, action):
    done = len(board.storage.log)
    assert bench.command(STORAGE, action) == dialect.MAV_RESULT_DENIED
    assert len(board.storage.log) == done
    assert bench.value("INNER_P") == 2.5


def test_reading_where_nothing_is_stored():
    bench = whole_board().boot()
    said(bench)
    bench.set(INNER_P=7.0)
    assert bench.command(STORAGE, READ) == FAILED
    assert said(bench) == ["no parameters in storage"]
    assert bench.value("INNER_P") == 7.0


@pytest.mark.parametrize("action", [WRITE, RESET])
def test_storage_that_fails(bench, board, action):
    bench.set(INNER_P=7.0)
    board.storage.full = True
    assert bench.command(STORAGE, action) == FAILED
    assert said(bench) == ["parameters not saved: storage failed"]
    assert board.boot(POWER_ON).value("INNER_P") == 2.5


def test_a_board_with_storage_only():
    board = Board(SimulatedStorage(), None)
    bench = board.boot()
    bench.set(INNER_P=7.0)
    assert bench.command(STORAGE, WRITE) == ACCEPTED
    assert board.boot(POWER_ON).value("INNER_P") == 7.0
