"""What takes more than a tick goes on in those that follow, with no new request to wake it, and comes to its end."""

import pytest
from firmware_bench import DO_SET_MODE, NAMES, PARK, TRACK, Bench, FlyingKite, command_long, of_kind, set_parameter
from test_foreign_requests import Station, ftp, unpack

from protocol import dialect

PING = dialect.MAVLink_ping_message(1, 2, 0, 0)
UNKNOWN_MODE = command_long(DO_SET_MODE, 1.0, 9.0)
CHANGED = {"POSITION_HZ": 7.0, "STATE_HZ": 25.0, "INNER_P": 2.5, "OUTER_L": 2.5, "FF_GAIN": 0.5, "SPEED_MIN": 0.5}


def is_idle(bench: Bench) -> bool:
    """True if no request waits for its turn."""
    inbox = bench.autopilot.inbox
    return not (inbox.orders.requests or inbox.questions.requests or inbox.urgent or inbox.files)


@pytest.fixture
def bench() -> Bench:
    """A kite in the sky, whose link has just no room for answers and whose stations wait for nothing."""
    made = Bench(FlyingKite())
    made.start(PARK)
    while is_idle(made):
        made.ask(*[PING] * 8)
    while not is_idle(made):
        made.step()
    return made


def told(bench: Bench, kind: str, *asked: dialect.MAVLink_message) -> tuple[list, list]:
    """What is said of this kind until no request waits any more, and what in the two seconds after that."""
    bench.tell(*asked)
    first = bench.step()
    while not is_idle(bench):
        first += bench.step()
    return of_kind(kind, first), of_kind(kind, bench.run(2.0))


def test_values_that_were_set_are_told_when_there_is_room(bench):
    first, later = told(bench, "PARAM_VALUE", *[set_parameter(name, value) for name, value in CHANGED.items()])
    assert len(first) < len(CHANGED)
    assert {value.param_id: value.param_value for value in first + later} == CHANGED


def test_refused_values_are_told_of_when_there_is_room(bench):
    first, later = told(bench, "PARAM_ERROR", *[set_parameter(f"NONE_{number}", 1.0) for number in range(6)])
    assert len(first) < 6
    assert [error.param_id for error in first + later] == [f"NONE_{number}" for number in range(6)]


def test_the_modes_are_told_when_there_is_room(bench):
    first, later = told(bench, "AVAILABLE_MODES", command_long(dialect.MAV_CMD_REQUEST_MESSAGE, 435.0))
    assert len(first) < 4
    assert [mode.mode_name for mode in first + later] == ["STANDBY", "MANUAL", "PARK", "TRACK"]


def test_a_list_goes_on(bench):
    first, later = told(bench, "PARAM_VALUE", dialect.MAVLink_param_request_list_message(1, 1))
    assert len(first) <= 2
    assert [value.param_id for value in first + later] == NAMES


def test_a_burst_goes_on(bench):
    """A file in pieces: who asked for the first gets the others."""
    station = Station(bench, 255)
    station.tell(ftp(dialect.MAV_FTP_OPCODE_OPENFILERO, data=b"general.json"))
    bench.run(0.5)
    first, later = told(bench, "FILE_TRANSFER_PROTOCOL", ftp(dialect.MAV_FTP_OPCODE_BURSTREADFILE, size=40))
    pieces = [unpack(answer) for answer in first + later]
    assert len(first) <= 1
    assert [offset for _, _, _, _, offset, _ in pieces] == [40 * number for number in range(len(pieces))]
    assert [complete for _, _, _, complete, _, _ in pieces] == [0] * (len(pieces) - 1) + [1]


def test_the_check_of_the_eight_goes_on(bench):
    first, later = told(bench, "COMMAND_ACK", command_long(DO_SET_MODE, 1.0, TRACK))
    assert not first
    assert [ack.result for ack in later] == [dialect.MAV_RESULT_ACCEPTED]
    first, later = told(bench, "PARAM_VALUE", set_parameter("EIGHT_ELEVATION", 42.0))
    assert not first
    assert [value.param_value for value in later] == [42.0]


@pytest.mark.parametrize("questions", [0, 20])
def test_acknowledgements_that_wait_go_out_at_their_pace(bench, questions):
    """54 at once and 27 a second; beside questions without end, for which there is no room, too."""
    stranger, operator = Station(bench, 66), Station(bench, 255)
    acknowledged = 0
    for _ in range(12):
        stranger.tell(*[PING] * questions)
        operator.tell(*[UNKNOWN_MODE] * 6)
        acknowledged += len(operator.answers("COMMAND_ACK", bench.step()))
    assert not bench.autopilot.inbox.orders.requests
    assert 54 <= acknowledged <= 62
    for _ in range(50):
        stranger.tell(*[PING] * questions)
        acknowledged += len(operator.answers("COMMAND_ACK", bench.step()))
    assert acknowledged == 72
