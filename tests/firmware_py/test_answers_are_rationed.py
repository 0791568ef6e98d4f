"""Answers are paid from the link's budget: heartbeats and steering go on as they were, whoever asks for what."""

import random
from collections.abc import Callable
from itertools import pairwise

import pytest
from firmware_bench import (
    ARM,
    DO_SET_MODE,
    MANUAL,
    PARK,
    TRACK,
    Bench,
    FlyingKite,
    command_long,
    of_kind,
    set_parameter,
)
from test_foreign_requests import Station, ftp

from firmware_py.mavlink.budget import LinkBudget
from protocol import dialect

LINE = 5760  # bytes/s of 57600 baud
PER_TICK = 40  # 2000 a second
SECONDS = 20


class Line:
    """A line of LINE bytes a second: what is sent waits behind what was sent before it."""

    def __init__(self) -> None:
        self.free_s = 0.0

    def carry(self, time_s: float, size: int) -> float:
        """When it has come out [s]."""
        self.free_s = max(self.free_s, time_s) + size / LINE
        return self.free_s


def worst_of_all(dice: random.Random, tick: int) -> list[tuple[int, dialect.MAVLink_message]]:
    """(system of the sender, message): the flood of the issue."""
    flood = [(66, command_long(DO_SET_MODE, 1.0, PARK, system=2))] * (PER_TICK // 2)
    for _ in range(PER_TICK // 2):
        flood.append((dice.randrange(1, 256), dice.choice([
            command_long(512, 435.0), command_long(dice.randrange(600, 3000)), command_long(DO_SET_MODE, 1.0, 9.0),
            command_long(512, 148.0), dialect.MAVLink_ping_message(1, 2, 0, 0),
            set_parameter("INNER_P", 1000.0), set_parameter("NO_SUCH", 1.0),
            dialect.MAVLink_param_request_read_message(1, 1, b"", 3), command_long(511, 50010.0, 1.0)])))
    flood.append((77, command_long(512, 435.0)))
    if tick % 50 == 0:
        flood.append((77, dialect.MAVLink_param_request_list_message(1, 1)))
    return flood


def files(dice: random.Random, tick: int) -> list[tuple[int, dialect.MAVLink_message]]:
    """Files, read again and again by several."""
    sender = dice.randrange(70, 80)
    return [(sender, ftp(dialect.MAV_FTP_OPCODE_OPENFILERO, data=b"parameters.json")),
            (sender, ftp(dialect.MAV_FTP_OPCODE_BURSTREADFILE, size=239))]


def refused_commands(dice: random.Random, tick: int) -> list[tuple[int, dialect.MAVLink_message]]:
    """Each is acknowledged, and refused with a text."""
    return [(dice.randrange(1, 256), command_long(DO_SET_MODE, 1.0, 9.0)) for _ in range(PER_TICK)]


def flown(flood: Callable | None, shared_line: bool, seed: int = 1) -> tuple[Bench, list[float], list[float]]:
    """The bench; ages of the steering and times of the heartbeats [s] at the other end of the line."""
    bench = Bench(FlyingKite())
    if shared_line:  # as a UART has it, which says its rate
        bench.autopilot.link.budget = LinkBudget(LINE)
    bench.start(TRACK)
    line, dice = Line(), random.Random(seed)
    stations = {system: Station(bench, system, 3) for system in range(256)}
    ages, beats = [], []
    for tick in range(SECONDS * 50):
        for system, message in flood(dice, tick) if flood else []:
            stations[system].tell(message)
        time_s = bench.time_s
        messages = bench.step()
        if shared_line:
            ages.append(line.carry(time_s, 32) - time_s)
        for message in messages:
            came_s = line.carry(time_s, len(message.get_msgbuf()))
            if message.get_type() == "HEARTBEAT":
                beats.append(came_s)
    return bench, ages, beats


def at_99_percent(values: list[float]) -> float:
    return sorted(values)[int(0.99 * len(values))]


@pytest.mark.parametrize("flood", [worst_of_all, files, refused_commands])
def test_on_a_line_with_the_steering_it_is_no_older_for_a_flood(flood):
    quiet, ages, _ = flown(None, True)
    flooded, ages_flooded, beats = flown(flood, True)
    assert quiet.steering == flooded.steering
    assert at_99_percent(ages) < 0.025
    assert at_99_percent(ages_flooded) < at_99_percent(ages) + 0.010
    assert len(beats) >= SECONDS - 1
    assert max(later - before for before, later in pairwise(beats)) < 1.1


@pytest.mark.parametrize("flood", [worst_of_all, files, refused_commands])
def test_heartbeats_go_on_behind_a_radio_of_which_the_firmware_knows_nothing(flood):
    bench, _, beats = flown(flood, False)
    assert len(beats) >= SECONDS - 1
    gaps = [later - before for before, later in pairwise(beats)]
    assert max(gaps) < 1.7 and max(gaps[5:]) < 1.1  # what is let through at once waits for 0.6 s there
    assert len(of_kind("KITE_STATE", [message for _, message in bench.heard])) > 0.48 * SECONDS * 50


@pytest.mark.parametrize("shared_line", [True, False])
def test_what_is_asked_beside_a_flood_of_one_sender_is_answered(shared_line):
    """Places in the queue, and turns, are shared between senders."""
    bench = Bench(FlyingKite())
    if shared_line:
        bench.autopilot.link.budget = LinkBudget(LINE)
    bench.start(TRACK)
    stranger, operator = Station(bench, 66), Station(bench, 255)
    answered = 0
    for tick in range(500):
        stranger.tell(*[command_long(512, 148.0)] * 10)
        if tick > 200 and tick % 50 == 0:
            operator.tell(dialect.MAVLink_ping_message(1, tick, 0, 0))
        answered += len(operator.answers("PING", bench.step()))
    assert answered >= 4


def test_a_command_is_acknowledged_in_its_tick_beside_questions_without_end():
    bench = Bench(FlyingKite())
    bench.start(TRACK)
    stranger, operator = Station(bench, 66), Station(bench, 255)
    for _ in range(100):
        stranger.tell(*[command_long(512, 148.0)] * 20)
        bench.step()
    for command in ((DO_SET_MODE, 1.0, MANUAL), (DO_SET_MODE, 1.0, PARK), (ARM, 0.0, 0.0)):
        stranger.tell(*[command_long(512, 148.0)] * 20)
        operator.tell(command_long(*command))
        (ack,) = operator.answers("COMMAND_ACK", bench.step())
        assert ack.result == dialect.MAV_RESULT_ACCEPTED


def test_the_eight_is_checked_beside_questions_without_end():
    bench = Bench(FlyingKite())
    bench.start(PARK)
    stranger, operator = Station(bench, 66), Station(bench, 254)
    for _ in range(100):
        stranger.tell(*[command_long(512, 148.0)] * 20)
        bench.step()
    operator.tell(command_long(DO_SET_MODE, 1.0, TRACK))
    for _ in range(10):
        stranger.tell(*[command_long(512, 148.0)] * 20)
        bench.step()
    assert bench.autopilot.modes.mode == TRACK


def test_commands_without_end_are_acknowledged_at_the_pace_that_is_theirs():
    """54 at once and 27 a second: whoever sends commands again and again cannot take the link."""
    bench = Bench(FlyingKite())
    bench.start(TRACK)
    stations = [Station(bench, system) for system in range(1, 11)]
    acks = []
    for _ in range(100):
        for station in stations:
            station.tell(command_long(DO_SET_MODE, 1.0, 9.0))
        acks += of_kind("COMMAND_ACK", bench.step())
    assert 100 <= len(acks) <= 54 + 2 * 27
    assert {ack.target_system for ack in acks} == set(range(1, 11))


def test_a_list_goes_out_at_once_and_a_second_one_at_the_pace_of_answers():
    bench = Bench()
    request = dialect.MAVLink_param_request_list_message(1, 1)
    bench.tell(request)
    assert len(of_kind("PARAM_VALUE", bench.run(0.5))) == len(bench.autopilot.parameters.values)
    for _ in range(40):
        bench.tell(request)
        bench.run(0.1)
    bench.tell(request)
    bytes_s = sum(len(message.get_msgbuf()) for message in of_kind("PARAM_VALUE", bench.run(1.0)))
    assert 1500 < bytes_s < 2600


def test_a_set_is_obeyed_at_once_and_answered_beside_questions_without_end():
    bench = Bench(FlyingKite())
    bench.start(TRACK)
    stranger, operator = Station(bench, 66), Station(bench, 255)
    heard = []
    for tick in range(200):
        stranger.tell(*[dialect.MAVLink_ping_message(1, 2, 0, 0)] * 10)
        if tick == 100:
            operator.tell(set_parameter("POSITION_HZ", 7.0), set_parameter("INNER_P", 1000.0))
        messages = bench.step()
        heard += messages
        if tick == 100:
            assert bench.value("POSITION_HZ") == 7.0
        if tick == 110:
            told = {value.param_id: value.param_value for value in of_kind("PARAM_VALUE", heard)}
            assert told == {"POSITION_HZ": 7.0, "INNER_P": bench.value("INNER_P")}
            assert [error.param_id for error in of_kind("PARAM_ERROR", heard)] == ["INNER_P"]
    assert len(of_kind("PING", heard)) > 100  # and the questions are answered, too, as far as there is room
