"""Floods and nonsense on the ground path: the flight stays the same to the bit, and whoever means it is heard."""

import random

import pytest
from firmware_bench import (
    ARM,
    DO_SET_MODE,
    MANUAL,
    PARK,
    STANDBY,
    TRACK,
    Bench,
    FlyingKite,
    command_long,
    of_kind,
    set_parameter,
)
from test_foreign_requests import Station, ftp

from firmware_py.mavlink.budget import LinkBudget
from firmware_py.mavlink.link import MavlinkLink
from firmware_py.services.inbox import Inbox
from protocol import dialect

ACCEPTED, REJECTED = dialect.MAV_RESULT_ACCEPTED, dialect.MAV_RESULT_TEMPORARILY_REJECTED
PER_TICK = 40  # 2000 a second
UNFLYABLE = {"EIGHT_HALF_H": 0.5, "STEER_MAX": 0.0625, "TURN_K": 0.0009765625, "LINE_LENGTH": 1.0,
             "EIGHT_AZIMUTH": 60.0, "WINDOW_ANGLE": 10.0}


def traffic(dice: random.Random) -> list[dialect.MAVLink_message]:
    """Valid messages that ask for much and change nothing."""
    choices = [
        lambda: dialect.MAVLink_ping_message(1, dice.randrange(99), 0, 0),
        lambda: dialect.MAVLink_param_request_list_message(1, 1),
        lambda: dialect.MAVLink_param_request_read_message(1, 1, b"", dice.randrange(60)),
        lambda: dialect.MAVLink_timesync_message(0, dice.randrange(1 << 40)),
        lambda: command_long(dice.randrange(600, 3000)),
        lambda: command_long(512, float(dice.choice([1, 148, 397, 435, 50010]))),
        lambda: ftp(dice.randrange(20), offset=dice.randrange(9999), data=b"parameters.json"),
        lambda: set_parameter(dice.choice(["NO_SUCH", "INNER_P"]), 1000.0),
        lambda: dialect.MAVLink_mission_request_list_message(1, 1, 0),
    ]
    return [dice.choice(choices)() for _ in range(PER_TICK // 2)]


def flood(bench: Bench, station: Station, dice: random.Random) -> None:
    """Half valid, half broken: cut short, flipped, noise."""
    station.tell(*traffic(dice))
    for datagram in bench._waiting[-PER_TICK // 2 :]:
        spoilt = bytearray(datagram)
        spoilt[dice.randrange(len(spoilt))] ^= 1 << dice.randrange(8)
        bench._waiting.append(dice.choice([bytes(spoilt), datagram[: dice.randrange(len(datagram))],
                                           dice.randbytes(dice.randrange(1, 300))]))


def test_two_thousand_packets_a_second_do_not_move_the_steering_by_a_bit():
    flights = []
    for flooded in (False, True):
        bench = Bench(FlyingKite())
        bench.start(TRACK)
        operator, stranger = Station(bench, 255), Station(bench, 77, 3)
        dice = random.Random(4)
        for tick in range(500):
            if flooded:
                flood(bench, stranger, dice)
            if tick % 100 == 50:  # what does not steer; the other station's flood is already waiting
                operator.tell(set_parameter("POSITION_HZ", tick / 50))
            if tick % 100 == 60:
                assert bench.value("POSITION_HZ") == (tick - 10) / 50
            bench.step()
        flights.append(bench.steering)
    assert flights[0] == flights[1]
    assert max(map(abs, flights[0])) > 0.1


def test_a_flood_from_the_operators_own_ids_is_no_shut_door():
    """Someone sends with the same ids: a set sent again and again, as ground stations do, gets through."""
    bench = Bench(FlyingKite())
    bench.start(TRACK)
    operator, stranger = Station(bench, 255), Station(bench, 255)
    dice = random.Random(5)
    for _ in range(25):
        flood(bench, stranger, dice)
        operator.tell(set_parameter("POSITION_HZ", 7.0))
        bench.step()
    assert bench.value("POSITION_HZ") == 7.0


@pytest.mark.parametrize(("command", "first", "second", "mode"), [
    (ARM, 0.0, 0.0, STANDBY), (DO_SET_MODE, 1.0, PARK, PARK), (DO_SET_MODE, 1.0, MANUAL, MANUAL)])
def test_a_flood_of_curves_to_check_holds_up_neither_commands_nor_other_parameters(command, first, second, mode):
    bench = Bench(FlyingKite())
    bench.start(TRACK)
    stranger, operator = Station(bench, 77), Station(bench, 255)

    def step() -> list:
        stranger.tell(*[set_parameter(name, value) for name, value in UNFLYABLE.items()] * 6)
        return bench.step()

    for _ in range(50):
        step()
    before = {name: bench.value(name) for name in UNFLYABLE}
    operator.tell(set_parameter("POSITION_HZ", 8.0), set_parameter("EIGHT_ELEVATION", 42.0))
    for _ in range(8):
        step()
    assert bench.value("POSITION_HZ") == 8.0
    for _ in range(30):  # a check of its own, behind the one that was running and one more
        step()
    assert bench.value("EIGHT_ELEVATION") == 42.0
    assert {name: bench.value(name) for name in UNFLYABLE} == before
    operator.tell(command_long(command, first, second))
    acks = []
    for _ in range(8):
        acks += operator.answers("COMMAND_ACK", step())
    assert [ack.result for ack in acks] == [ACCEPTED]
    assert bench.autopilot.modes.mode == mode


@pytest.mark.parametrize("rest", [(ARM, 0.0, 0.0), (DO_SET_MODE, 1.0, PARK)])
def test_what_brings_the_kite_to_rest_is_not_undone_by_what_was_asked_before(rest):
    """TRACK is still being checked, or waits, when PARK or disarming comes: that stays the last word."""
    for gap in (0, 1, 3):
        bench = Bench(FlyingKite())
        bench.start(PARK)
        bench.tell(command_long(DO_SET_MODE, 1.0, TRACK))
        for _ in range(gap):
            bench.step()
        bench.tell(command_long(*rest))
        messages = bench.run(1.0)
        assert sorted((ack.command, ack.result) for ack in of_kind(
            "COMMAND_ACK", [m for _, m in bench.heard] or messages)) == sorted(
                [(DO_SET_MODE, REJECTED), (rest[0], ACCEPTED)])
        assert bench.autopilot.modes.mode == (PARK if rest[0] == DO_SET_MODE else STANDBY)


def test_telemetry_gives_way_where_the_link_carries_little():
    bench = Bench(FlyingKite())
    bench.autopilot.link.budget = LinkBudget(3000)  # steering alone is 1600 of them
    bench.start(TRACK)
    messages = bench.run(10.0)
    assert 9 <= len(of_kind("HEARTBEAT", messages)) <= 11
    assert 50 < len(of_kind("KITE_STATE", messages)) < 250
    size = sum(len(message.get_msgbuf()) for message in messages)
    assert size < 10 * 3000
    assert bench.command(410) == dialect.MAV_RESULT_UNSUPPORTED
    bench.autopilot.link.budget = LinkBudget(960)  # less than steering needs
    bench.tell(dialect.MAVLink_param_request_list_message(1, 1))
    names = {value.param_id for value in of_kind("PARAM_VALUE", bench.run(12.0))}
    assert len(names) == len(bench.autopilot.parameters.values)


def test_a_radio_whose_buffer_fills_is_sent_less_and_more_again_when_it_is_empty():
    bench = Bench(FlyingKite())
    bench.start(TRACK)
    radio = Station(bench, 51, 68)

    def states(free: int) -> int:
        """How many come in the last of ten seconds, in each of which the radio says that `free` percent are left."""
        messages = []
        for _ in range(10):
            radio.tell(dialect.MAVLink_radio_status_message(200, 200, free, 30, 30, 0, 0))
            messages = bench.run(1.0)
        return len(of_kind("KITE_STATE", messages))

    full = states(100)
    assert states(5) < full / 4
    assert len(of_kind("HEARTBEAT", [m for t, m in bench.heard if t > bench.time_s - 5.0])) >= 4
    states(100)
    assert states(100) > 0.9 * full
    states(5)
    bench.run(11.0)  # the radio is gone
    assert len(of_kind("KITE_STATE", bench.run(1.0))) >= 49


def test_what_a_tick_takes_in_is_bounded_and_the_rest_waits():
    """A board's loop says how many bytes; a datagram that has begun is taken whole."""
    ping = dialect.MAVLink_ping_message(1, 2, 0, 0).pack(dialect.MAVLink(None, 255, 190))

    class Waiting:
        datagrams = True
        left = 1000

        def read(self) -> bytes:
            self.left -= 1
            return ping

        def write(self, data: memoryview) -> None:
            """Nobody listens."""

    transport = Waiting()
    inbox = Inbox()
    taken = MavlinkLink(transport).receive(inbox, 2048)
    assert 2048 <= taken < 2048 + len(ping)
    assert (1000 - transport.left) * len(ping) == taken
