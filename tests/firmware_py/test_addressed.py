"""Frames that are not for this system end in the link: no queue, sample or handler sees them."""

import pytest
from any_message import fields
from firmware_bench import (
    ARM,
    DO_SET_MODE,
    MANUAL,
    NAMES,
    PARK,
    STANDBY,
    TRACK,
    Bench,
    FlyingKite,
    command_long,
    of_kind,
    set_parameter,
)
from test_codec import theirs
from test_foreign_requests import Station

from firmware_py.mavlink.generated_messages import MESSAGES, TARGETS
from firmware_py.mavlink.link import MavlinkLink
from firmware_py.services.inbox import Inbox
from protocol import dialect

OWN = 7


class Datagrams:
    datagrams = True

    def __init__(self, *data: bytes):
        self.waiting = list(data)

    def read(self) -> bytes | None:
        return self.waiting.pop(0) if self.waiting else None

    def write(self, data: memoryview) -> None:
        """Nobody listens."""


class Seen(Inbox):
    """Whatever the link hands on."""

    def __init__(self) -> None:
        super().__init__()
        self.all: list[tuple[int, int, int, int | None]] = []

    def put(self, message, values, system, component, sequence=None):
        self.all.append((message, system, component, sequence))


def aimed(number: int, system: int, component: int, sequence: int = 0) -> bytes:
    """A frame of message `number` for this system and component, from 255/190; all else in it is 1."""
    kind = dialect.mavlink_map[number]
    aims = {"target_system": system, "target": system, "target_component": component}
    values = []
    for name, (count, code) in zip(kind.ordered_fieldnames, fields(kind.unpacker.format), strict=True):
        one = aims.get(name, 1)
        values.append(b"A" if code == "s" else [one] * count if count else one)
    mav = dialect.MAVLink(None, 255, 190)
    mav.seq = sequence
    return theirs(number, values, mav)


def handed_on(*frames: bytes) -> tuple[MavlinkLink, list]:
    link, inbox = MavlinkLink(Datagrams(*frames)), Seen()
    link.set_system(OWN)
    link.receive(inbox)
    return link, inbox.all


@pytest.mark.parametrize("number", sorted(TARGETS), ids=lambda n: dialect.mavlink_map[n].msgname)
def test_only_what_is_for_this_system_or_all_of_them_gets_in(number):
    has_component = "target_component" in dialect.mavlink_map[number].fieldnames
    for system, component, gets_in in (
            (OWN, 1, True), (OWN, 0, True), (0, 1, True), (0, 0, True), (OWN + 1, 1, False), (OWN + 1, 0, False),
            (OWN, 25, not has_component), (0, 2, not has_component)):
        link, seen = handed_on(aimed(number, system, component))
        assert (len(seen), link.decoder.foreign) == ((1, 0) if gets_in else (0, 1)), (system, component)


def test_every_message_that_names_a_target_is_in_the_table():
    named = {number for number, kind in dialect.mavlink_map.items()
             if {"target_system", "target"} & set(kind.fieldnames)}
    assert set(TARGETS) == named & set(MESSAGES)


def test_the_number_of_a_frame_is_handed_on_and_foreign_ones_are_no_loss():
    frames = [aimed(76, OWN if sequence % 3 else OWN + 1, 1, sequence) for sequence in range(9)]
    link, seen = handed_on(*frames)
    assert seen == [(76, 255, 190, sequence) for sequence in (1, 2, 4, 5, 7, 8)]
    assert link.counters() == (0, 3, 0, 0)


def test_strangers_who_talk_to_others_do_not_take_the_places_of_those_whose_losses_are_counted():
    strangers = []
    for system in range(20):
        mav = dialect.MAVLink(None, system + 1, 1)
        strangers.append(dialect.MAVLink_param_request_list_message(OWN + 1, 1).pack(mav))
    link, _ = handed_on(*strangers, aimed(76, OWN, 1, 3), aimed(76, OWN, 1, 6))
    assert link.decoder.lost == 2


@pytest.mark.parametrize("command", [(DO_SET_MODE, 1.0, PARK), (ARM, 0.0, 0.0)])
def test_a_flood_for_another_system_leaves_room_for_disarm(command):
    """750 PARKs a second for system 2, and a DISARM for this one in the middle: it acts in its own tick."""
    bench = Bench(FlyingKite())
    bench.start(TRACK)
    stranger, operator = Station(bench, 66), Station(bench, 255)
    for tick in range(50):
        stranger.tell(*[command_long(*command, system=2)] * 15)
        if tick == 25:
            operator.tell(command_long(ARM, 0.0))
        bench.step()
        assert bench.autopilot.inbox.refused == 0
        assert (bench.autopilot.modes.mode == STANDBY) == (tick >= 25)


def test_an_address_that_is_changed_is_the_address_from_then_on():
    bench = Bench()
    bench.tell(set_parameter("SYSTEM_ID", 9.0, system=1))
    bench.run(0.1)
    bench.tell(set_parameter("INNER_P", 2.5, system=1))
    bench.run(0.1)
    assert bench.value("INNER_P") != 2.5
    bench.tell(set_parameter("INNER_P", 2.5, system=9))
    bench.run(0.1)
    assert bench.value("INNER_P") == 2.5


@pytest.mark.parametrize("component", [1, 0])
def test_a_kite_of_another_number_does_all_that_it_is_asked(component):
    """What is checked as the eight is, and refused, shows that nothing slips past the check under another address."""
    bench = Bench(FlyingKite())
    bench.set(SYSTEM_ID=OWN)
    bench.step()
    listed = bench.ask(dialect.MAVLink_param_request_list_message(OWN, component)) + bench.run(1.0)
    assert {value.param_id for value in of_kind("PARAM_VALUE", listed)} == set(NAMES)
    bench.run(3.0)

    read = dialect.MAVLink_param_request_read_message(OWN, component, b"INNER_P", -1)
    assert [value.param_id for value in of_kind("PARAM_VALUE", bench.ask(read))] == ["INNER_P"]
    missions = of_kind("MISSION_COUNT", bench.ask(dialect.MAVLink_mission_request_list_message(OWN, component)))
    assert [mission.target_system for mission in missions] == [255]

    def command(number: int, first: float, second: float = 0.0) -> list[int]:
        bench.tell(dialect.MAVLink_command_long_message(OWN, component, number, 0, first, second, 0, 0, 0, 0, 0))
        return [ack.result for ack in of_kind("COMMAND_ACK", bench.run(0.4))]

    def set_as(name: str, value: float) -> None:
        bench.tell(dialect.MAVLink_param_set_message(OWN, component, name.encode(), value, 9))
        bench.run(0.4)

    accepted, rejected = [dialect.MAV_RESULT_ACCEPTED], [dialect.MAV_RESULT_TEMPORARILY_REJECTED]
    assert command(ARM, 1.0) == command(DO_SET_MODE, 1.0, TRACK) == accepted
    set_as("EIGHT_LEAST_EL", 40.0)
    assert bench.value("EIGHT_LEAST_EL") == 10.0
    assert command(DO_SET_MODE, 1.0, PARK) == accepted
    set_as("EIGHT_LEAST_EL", 40.0)
    assert bench.value("EIGHT_LEAST_EL") == 40.0
    assert command(DO_SET_MODE, 1.0, TRACK) == rejected
    assert command(DO_SET_MODE, 1.0, MANUAL) == accepted


@pytest.mark.parametrize("target", [OWN, 0])
def test_sticks_are_followed_whatever_their_other_buttons_are(target):
    bench = Bench()
    bench.set(SYSTEM_ID=OWN)
    bench.step()
    bench.tell(command_long(ARM, 1.0, system=OWN), command_long(DO_SET_MODE, 1.0, MANUAL, system=OWN))
    bench.run(0.4)
    bench.tell(dialect.MAVLink_manual_control_message(target, 0, 250, 0, 0, 0, buttons2=5))
    bench.run(0.06)
    assert bench.steering[-1] == 0.25
