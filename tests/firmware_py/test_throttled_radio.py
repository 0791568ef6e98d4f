"""A radio whose buffer is full carries less than the steering takes: what an operator must hear still comes."""

import pytest
from firmware_bench import ARM, DO_SET_MODE, MANUAL, PARK, STANDBY, Bench, FlyingKite, command_long, of_kind
from test_foreign_requests import Station

from protocol import dialect

ACCEPTED = dialect.MAV_RESULT_ACCEPTED
SOON_TICKS = 15  # 0.3 s
PING = dialect.MAVLink_ping_message(1, 2, 0, 0)
LIST = dialect.MAVLink_param_request_list_message(1, 1)


def throttled(reports: int) -> Bench:
    """A kite in PARK whose radio has said so often that 5 % of its buffer are free."""
    bench = Bench(FlyingKite())
    bench.start(PARK)
    radio = Station(bench, 51, 68)
    for _ in range(reports):
        radio.tell(dialect.MAVLink_radio_status_message(200, 200, 5, 30, 30, 0, 0))
        bench.run(0.6)
    return bench


@pytest.mark.parametrize("reports", [1, 3, 10])
@pytest.mark.parametrize("questions", [[], [LIST], [PING] * 3, [LIST, *[PING] * 60]])
def test_a_disarm_is_acknowledged_soon_whatever_waits_for_an_answer(reports, questions):
    bench = throttled(reports)
    stranger, operator = Station(bench, 66), Station(bench, 255)
    stranger.tell(*questions)
    bench.run(0.1)
    operator.tell(command_long(ARM, 0.0))
    acks = operator.answers("COMMAND_ACK", [message for _ in range(SOON_TICKS) for message in bench.step()])
    assert [ack.result for ack in acks] == [ACCEPTED]
    assert bench.autopilot.modes.mode == STANDBY


def test_commands_in_a_hurry_are_all_acknowledged_soon_beside_questions_without_end():
    bench = throttled(3)
    stranger, operator = Station(bench, 66), Station(bench, 255)
    for _ in range(50):
        stranger.tell(*[PING] * 10)
        bench.step()
    operator.tell(command_long(DO_SET_MODE, 1.0, MANUAL), command_long(DO_SET_MODE, 1.0, PARK), command_long(ARM, 0.0))
    acks = []
    for _ in range(SOON_TICKS):
        stranger.tell(*[PING] * 10)
        acks += operator.answers("COMMAND_ACK", bench.step())
    assert len(acks) == 3


def test_texts_come_and_answers_go_on_beside_questions_without_end():
    bench = throttled(3)
    stranger, operator = Station(bench, 66), Station(bench, 255)
    bench.heard.clear()
    for tick in range(200):
        stranger.tell(*[PING] * 10)
        if tick == 50:
            operator.tell(command_long(DO_SET_MODE, 1.0, 9.0))  # refused, with a text
        bench.step()
    said = [time_s for time_s, message in bench.heard if message.get_type() == "STATUSTEXT"]
    asked_s = bench.time_s - 150 * 0.02
    assert said and said[0] - asked_s < 0.3
    assert len(of_kind("PING", [message for _, message in bench.heard])) >= 15
