"""Stories of commands that come one after the other: what is overtaken, and copies that come late over another link."""

import pytest
from firmware_bench import (
    ARM,
    DO_SET_MODE,
    MANUAL,
    PARK,
    PERIOD_S,
    STANDBY,
    TRACK,
    Bench,
    command_long,
    of_kind,
    station_heartbeat,
)

from protocol import dialect

ACCEPTED, REJECTED = dialect.MAV_RESULT_ACCEPTED, dialect.MAV_RESULT_TEMPORARILY_REJECTED
ARMS, DISARMS = command_long(ARM, 1.0), command_long(ARM, 0.0)


def mode_command(mode: int) -> dialect.MAVLink_message:
    return command_long(DO_SET_MODE, 1.0, mode)


def a_copied_frame(bench: Bench, message: dialect.MAVLink_message) -> bytes:
    """A frame of the station as it goes out, to be sent over each of its links."""
    frame = bytes(message.pack(bench._station))
    bench._station.seq = (bench._station.seq + 1) % 256
    return frame


def answers_to(bench: Bench, *frames: bytes, seconds: float = 0.4) -> list[tuple[int, int]]:
    """(command, result) of what is answered after the frames have arrived in one tick."""
    bench._waiting += frames
    return [(ack.command, ack.result) for ack in of_kind("COMMAND_ACK", bench.run(seconds))]


@pytest.mark.parametrize("later", [MANUAL, PARK, STANDBY])
def test_a_command_to_track_that_waits_is_overtaken_by_a_later_one(later):
    bench = Bench()
    bench.start(PARK)
    bench.tell(mode_command(TRACK))
    bench.step()  # the eight is being checked
    bench.tell(mode_command(later))
    answers = [(ack.result, bench.time_s) for ack in of_kind("COMMAND_ACK", bench.run(0.4))]
    assert [result for result, _ in answers] == [REJECTED, ACCEPTED]
    assert bench.autopilot.modes.mode == later


@pytest.mark.parametrize(("command", "first", "second", "result"), [
    (DO_SET_MODE, 1.0, 77.0, REJECTED), (ARM, 5.0, 0.0, dialect.MAV_RESULT_DENIED),
    (dialect.MAV_CMD_PREFLIGHT_STORAGE, 1.0, 0.0, REJECTED),
    (dialect.MAV_CMD_SET_MESSAGE_INTERVAL, 0.0, 0.0, ACCEPTED)])
def test_what_asks_for_no_mode_that_there_is_overtakes_nothing(command, first, second, result):
    bench = Bench()
    bench.start(PARK)
    bench.tell(mode_command(TRACK))
    bench.step()  # the eight is being checked
    bench.tell(command_long(command, first, second))
    assert [ack.result for ack in of_kind("COMMAND_ACK", bench.run(0.4))] == [result, ACCEPTED]
    assert bench.mode == TRACK


@pytest.mark.parametrize("later", [MANUAL, PARK, STANDBY])
def test_a_late_copy_of_a_command_changes_nothing(later):
    """The same station over a second link, half a second slower: its frames have the same numbers."""
    bench = Bench()
    bench.set(MANUAL_TIME=5.0)
    bench.start(PARK)
    track = mode_command(TRACK).pack(bench._station)
    bench._station.seq += 1
    bench._waiting.append(track)
    bench.run(0.3)
    assert bench.mode == TRACK
    bench.tell(mode_command(later))
    bench.run(0.3)
    bench._waiting.append(track)
    (answer,) = of_kind("COMMAND_ACK", bench.run(0.3))
    assert answer.result == REJECTED
    assert bench.autopilot.modes.mode == later
    if later != STANDBY:
        assert bench.change_mode(TRACK) == ACCEPTED  # asked for again, it is a new command


@pytest.mark.parametrize("wait_ticks", [1, 15])  # while TRACK waits for the check of the eight, and when it flies it
def test_a_late_copy_does_not_undo_what_another_station_asked_for(wait_ticks):
    bench = Bench()
    bench.start(PARK)
    track = a_copied_frame(bench, mode_command(TRACK))
    bench._waiting.append(track)
    bench.run(wait_ticks * PERIOD_S)
    bench._waiting.append(mode_command(PARK).pack(dialect.MAVLink(None, 7, 190)))
    bench.run(0.3)
    assert bench.mode == PARK
    bench._waiting.append(track)
    bench.run(0.3)
    assert bench.mode == PARK
    assert bench.texts()[-1] == "overtaken by a later command"


def test_a_late_copy_does_not_undo_a_fail_safe():
    bench = Bench()
    bench.start(PARK)
    manual = a_copied_frame(bench, mode_command(MANUAL))
    bench._waiting.append(manual)
    bench.run(0.7)
    assert bench.texts()[-1] == "no MANUAL_CONTROL: PARK"
    bench._waiting.append(manual)
    bench.run(0.1)
    assert bench.mode == PARK


def test_a_copy_of_what_is_still_so_is_accepted():
    bench = Bench()
    bench.start(PARK)
    track = a_copied_frame(bench, mode_command(TRACK))
    for _ in range(3):
        bench._waiting.append(track)
        (answer,) = of_kind("COMMAND_ACK", bench.run(0.3))
        assert answer.result == ACCEPTED
    assert bench.mode == TRACK


def test_arming_and_tracking_in_one_breath_come_in_their_order():
    bench = Bench()
    bench.run(0.2)
    bench.tell(command_long(ARM, 1.0), mode_command(TRACK))
    answers = of_kind("COMMAND_ACK", bench.run(0.6))
    assert [(ack.command, ack.result) for ack in answers] == [(ARM, ACCEPTED), (DO_SET_MODE, ACCEPTED)]
    assert bench.mode == TRACK
    bench.disarm()
    bench.tell(command_long(ARM, 1.0), mode_command(MANUAL))
    bench.run(0.4)
    assert bench.mode == MANUAL
    bench.disarm()
    bench.tell(command_long(ARM, 1.0), mode_command(PARK))
    assert [ack.result for ack in of_kind("COMMAND_ACK", bench.run(0.4))] == [ACCEPTED, ACCEPTED]
    assert bench.mode == PARK


@pytest.mark.parametrize("overtaken", [MANUAL, TRACK])
def test_what_a_park_of_the_same_tick_has_overtaken_does_not_come_back(overtaken):
    bench = Bench()
    bench.start(PARK)
    command, park = (a_copied_frame(bench, mode_command(mode)) for mode in (overtaken, PARK))
    assert answers_to(bench, command, park) == [(DO_SET_MODE, ACCEPTED), (DO_SET_MODE, REJECTED)]  # PARK comes first
    assert answers_to(bench, command) == [(DO_SET_MODE, REJECTED)]
    assert bench.mode == PARK


@pytest.mark.parametrize("before", [DISARMS, mode_command(STANDBY)])
def test_a_late_copy_of_a_disarm_leaves_what_waits_alone(before):
    bench = Bench()
    bench.set(MANUAL_TIME=5.0)
    disarm = a_copied_frame(bench, before)
    assert answers_to(bench, disarm) == [(before.command, ACCEPTED)]  # type: ignore[attr-defined]
    bench.tell(ARMS, mode_command(MANUAL))
    bench.step()
    assert answers_to(bench, disarm) == [(before.command, ACCEPTED), (ARM, ACCEPTED), (DO_SET_MODE, ACCEPTED)]  # type: ignore[attr-defined]
    assert bench.mode == MANUAL
    assert answers_to(bench, disarm) == [(before.command, REJECTED)]  # type: ignore[attr-defined]
    assert bench.mode == MANUAL


def test_a_disarm_that_comes_for_the_first_time_is_obeyed_however_late():
    bench = Bench()
    bench.run(0.1)
    disarm = a_copied_frame(bench, DISARMS)
    arm = a_copied_frame(bench, ARMS)
    assert answers_to(bench, arm) == [(ARM, ACCEPTED)]
    assert answers_to(bench, disarm) == [(ARM, ACCEPTED)]
    assert bench.mode == STANDBY
    assert answers_to(bench, arm) == [(ARM, REJECTED)]  # its number is newer than the disarm's, and yet it is a copy
    assert bench.mode == STANDBY


def test_a_late_copy_of_what_is_so_does_not_let_another_copy_pass():
    bench = Bench()
    bench.run(0.1)
    standby, arm, disarm = (a_copied_frame(bench, message) for message in (mode_command(STANDBY), ARMS, DISARMS))
    for frame in (standby, arm, disarm):
        ((_, result),) = answers_to(bench, frame)
        assert result == ACCEPTED
    assert answers_to(bench, standby) == [(DO_SET_MODE, ACCEPTED)]
    assert answers_to(bench, arm) == [(ARM, REJECTED)]
    assert bench.mode == STANDBY


def test_a_late_copy_of_park_overtakes_nothing():
    bench = Bench()
    bench.start(TRACK)
    park = a_copied_frame(bench, mode_command(PARK))
    assert answers_to(bench, park) == [(DO_SET_MODE, ACCEPTED)]
    manual = a_copied_frame(bench, mode_command(MANUAL))
    assert sorted(answers_to(bench, manual, park)) == [(DO_SET_MODE, ACCEPTED)] * 2
    assert bench.mode == MANUAL
    bench.change_mode(PARK)
    bench.tell(mode_command(TRACK))
    bench.step()  # the eight is being checked
    assert answers_to(bench, park) == [(DO_SET_MODE, ACCEPTED)] * 2
    assert bench.mode == TRACK


@pytest.mark.parametrize("wanted", [MANUAL, TRACK, PARK])
def test_a_copy_of_what_was_refused_stays_refused(wanted):
    bench = Bench()
    bench.run(0.1)
    command = a_copied_frame(bench, mode_command(wanted))
    assert answers_to(bench, command) == [(DO_SET_MODE, REJECTED)]
    assert bench.arm() == ACCEPTED
    bench.change_mode(MANUAL if wanted == PARK else PARK)
    before = bench.mode
    assert answers_to(bench, command) == [(DO_SET_MODE, REJECTED)]
    assert bench.mode == before


def test_the_last_word_on_a_refusal_is_its_reason_though_copies_come():
    bench = Bench()
    bench.start(PARK)
    bench.set(EIGHT_LEAST_EL=40.0)
    track = a_copied_frame(bench, mode_command(TRACK))
    assert answers_to(bench, track, track) == [(DO_SET_MODE, REJECTED)] * 2
    assert answers_to(bench, track) == [(DO_SET_MODE, REJECTED)]
    assert "minimum is 40.0" in bench.texts()[-1]


def test_an_arm_that_comes_after_the_track_behind_it_is_obeyed():
    """A link has lost the first of the two; a second link brings both."""
    bench = Bench()
    bench.run(0.1)
    arm, track = (a_copied_frame(bench, message) for message in (ARMS, mode_command(TRACK)))
    assert answers_to(bench, track) == [(DO_SET_MODE, REJECTED)]
    assert answers_to(bench, arm) == [(ARM, ACCEPTED)]
    assert bench.mode == PARK


@pytest.mark.parametrize("overtaken", [MANUAL, TRACK])
def test_a_copy_of_what_waits_does_not_come_after_what_waits_behind_it(overtaken):
    bench = Bench()
    bench.run(0.1)
    bench.tell(ARMS)
    command = a_copied_frame(bench, mode_command(overtaken))
    bench._waiting.append(command)
    bench.tell(mode_command(PARK))
    bench.step()
    acknowledged = answers_to(bench, command, seconds=0.8)
    assert [result for _, result in acknowledged] == [ACCEPTED, ACCEPTED, ACCEPTED, REJECTED]
    assert bench.mode == PARK


def test_eight_commands_may_wait():
    bench = Bench()
    bench.run(0.1)
    bench.tell(*[ARMS] * 5)
    bench.step()
    bench.tell(*[mode_command(MANUAL)] * 4)
    assert [result for _, result in answers_to(bench)] == [REJECTED] + [ACCEPTED] * 8
    assert bench.mode == MANUAL


def test_a_station_is_heard_when_its_command_arrives_and_not_by_late_copies():
    bench = Bench()
    bench.set(GCS_LOST_TIME=2.0)
    bench.start(PARK)
    bench.tell(station_heartbeat())
    bench.run(1.0)
    track = a_copied_frame(bench, mode_command(TRACK))
    arrived_s = bench.time_s
    assert answers_to(bench, track, seconds=1.0) == [(DO_SET_MODE, ACCEPTED)]
    assert answers_to(bench, track, seconds=0.5) == [(DO_SET_MODE, ACCEPTED)]
    while bench.mode == TRACK:
        bench.step()
    assert bench.time_s - PERIOD_S - arrived_s == pytest.approx(2.0 + PERIOD_S)
    assert bench.texts()[-1] == "ground station silent: PARK"
