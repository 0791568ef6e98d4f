"""Commands over several links: late copies, numbers, and which of those that come in one breath is the last word.

The kite is system 9 here and every command says that it is sent a third time: neither must matter.
"""

import pytest
from firmware_bench import ARM, DO_SET_MODE, MANUAL, PARK, PERIOD_S, STANDBY, TRACK, Bench, of_kind, set_parameter

from firmware_py.control.figure_eight import CURVE_PARAMETERS
from protocol import dialect

ACCEPTED, REJECTED = dialect.MAV_RESULT_ACCEPTED, dialect.MAV_RESULT_TEMPORARILY_REJECTED
SYSTEM = 9
ARMING, DISARM = (ARM, 1.0, 0.0), (ARM, 0.0, 0.0)
TO_STANDBY, TO_MANUAL, TO_PARK, TO_TRACK = ((DO_SET_MODE, 1.0, float(mode)) for mode in (STANDBY, MANUAL, PARK, TRACK))
LATE_TEXT = "overtaken by a later command"

Wish = tuple[int, float, float]


def frame(number: int, wish: Wish, station: int = 255) -> bytes:
    """A command as a station sends it, in a frame with this number."""
    mav = dialect.MAVLink(None, station, 190)
    mav.seq = number
    command, first, second = wish
    return bytes(dialect.MAVLink_command_long_message(
        SYSTEM, 1, command, 2, first, second, 0.0, 0.0, 0.0, 0.0, 0.0).pack(mav))


def results(bench: Bench, *frames: bytes, seconds: float = 0.3) -> list[int]:
    """What is answered to `frames`, which arrive in one tick; long enough for the check of the eight."""
    bench._waiting += frames
    return [ack.result for ack in of_kind("COMMAND_ACK", bench.run(seconds))]


@pytest.fixture
def grounded() -> Bench:
    """A kite on the ground that has samples, and no command in its memory."""
    bench = Bench()
    bench.set(MANUAL_TIME=5.0, SYSTEM_ID=SYSTEM)
    bench.run(4.0)
    return bench


@pytest.fixture
def parked(grounded) -> Bench:
    """The same kite, in PARK for longer than commands are remembered."""
    assert results(grounded, frame(100, ARMING, 200)) == [ACCEPTED]
    grounded.run(4.0)
    grounded.heard.clear()
    return grounded


def mode(bench: Bench) -> int:
    return bench.autopilot.modes.mode


def test_a_late_copy_of_arm_does_not_arm_a_kite_that_was_disarmed(grounded):
    assert results(grounded, frame(1, ARMING)) == [ACCEPTED]
    assert results(grounded, frame(2, DISARM)) == [ACCEPTED]
    assert results(grounded, frame(1, ARMING)) == [REJECTED]
    assert mode(grounded) == STANDBY
    assert grounded.texts()[-1] == LATE_TEXT
    assert results(grounded, frame(3, ARMING)) == [ACCEPTED]


@pytest.mark.parametrize(("safe", "since"), [
    (TO_PARK, [TO_PARK, TO_TRACK]), (TO_MANUAL, [TO_MANUAL, TO_TRACK]), (DISARM, [DISARM, ARMING])])
def test_what_is_safe_is_obeyed_though_it_comes_late_as_long_as_it_is_no_copy(parked, safe, since):
    """The slow link alone has carried it; another of its kind went over the fast one."""
    for number, wish in enumerate(since, start=2):
        assert results(parked, frame(number, wish)) == [ACCEPTED]
    before = mode(parked)
    assert results(parked, frame(1, safe)) == [ACCEPTED]
    assert mode(parked) == {TO_PARK: PARK, TO_MANUAL: MANUAL, DISARM: STANDBY}[safe] != before


def test_track_that_comes_late_is_not_obeyed_though_it_is_no_copy(parked):
    assert results(parked, frame(2, TO_MANUAL)) == [ACCEPTED]
    assert results(parked, frame(1, TO_TRACK)) == [REJECTED]
    assert mode(parked) == MANUAL


@pytest.mark.parametrize(("last", "number", "result"), [
    (40, 8, REJECTED), (40, 7, ACCEPTED), (2, 250, REJECTED), (2, 226, REJECTED), (2, 225, ACCEPTED),
    (250, 2, ACCEPTED)])
def test_a_number_is_late_up_to_32_behind_the_last_over_the_wrap_too(parked, last, number, result):
    """Further behind, the station has begun anew."""
    assert results(parked, frame(last, TO_MANUAL)) == [ACCEPTED]
    assert results(parked, frame(number, TO_TRACK)) == [result]


@pytest.mark.parametrize(("after_s", "result"), [(2.98, REJECTED), (3.0, ACCEPTED)])
def test_a_command_is_remembered_for_three_seconds(parked, after_s, result):
    assert results(parked, frame(5, TO_MANUAL), seconds=after_s) == [ACCEPTED]
    assert results(parked, frame(4, TO_TRACK)) == [result]


@pytest.mark.parametrize(("others", "result"), [(7, REJECTED), (8, ACCEPTED)])
def test_the_last_eight_commands_are_remembered_whoever_sent_them(parked, others, result):
    assert results(parked, frame(9, TO_TRACK)) == [ACCEPTED]
    for station in range(1, 1 + others):
        wish = TO_PARK if station % 2 else TO_MANUAL
        assert results(parked, frame(50, wish, station), seconds=PERIOD_S) == [ACCEPTED]
    assert results(parked, frame(9, TO_TRACK)) == [result]


def test_a_station_that_gives_every_frame_the_same_number_is_obeyed_where_it_is_safe(grounded):
    for wish, then in ((ARMING, PARK), (TO_MANUAL, MANUAL), (TO_PARK, PARK), (DISARM, STANDBY)):
        assert results(grounded, frame(0, wish)) == [ACCEPTED]
        assert mode(grounded) == then


def test_commands_without_a_number_are_obeyed_as_they_come(parked):
    """From inside the process there are no frames."""
    for wanted in (MANUAL, TRACK, PARK, TRACK):
        values = (1.0, float(wanted), 0.0, 0.0, 0.0, 0.0, 0.0, DO_SET_MODE, SYSTEM, 1, 0)
        parked.autopilot.inbox.put(dialect.MAVLINK_MSG_ID_COMMAND_LONG, values, 255, 190)
        parked.run(0.3)
        assert mode(parked) == wanted


def test_without_numbers_too_a_park_has_the_last_word_over_what_came_before_it_in_its_tick(parked):
    for wanted in (MANUAL, PARK):
        values = (1.0, float(wanted), 0.0, 0.0, 0.0, 0.0, 0.0, DO_SET_MODE, SYSTEM, 1, 0)
        parked.autopilot.inbox.put(dialect.MAVLINK_MSG_ID_COMMAND_LONG, values, 255, 190)
    assert sorted(results(parked)) == sorted([ACCEPTED, REJECTED])
    assert mode(parked) == PARK


def test_a_copy_of_a_refused_command_stays_refused_and_asking_again_is_a_new_command(parked):
    """TRACK while samples are stale; they are back when its copy comes over the slow link."""
    sky, parked.sky = parked.sky, None
    parked.run(0.6)
    assert results(parked, frame(5, TO_TRACK)) == [REJECTED]
    parked.sky = sky
    parked.run(0.7)
    assert results(parked, frame(5, TO_TRACK)) == [REJECTED]
    assert results(parked, frame(6, TO_TRACK)) == [ACCEPTED]


def test_a_copy_of_what_was_overtaken_while_it_waited_is_late(grounded):
    """ARM and MANUAL wait for the check of the eight when DISARM comes; the kite is armed anew before MANUAL's copy."""
    grounded._waiting += [frame(1, ARMING), frame(2, TO_MANUAL)]
    grounded.step()
    assert sorted(results(grounded, frame(3, DISARM))) == sorted([REJECTED, REJECTED, ACCEPTED])
    assert results(grounded, frame(4, ARMING)) == [ACCEPTED]
    assert results(grounded, frame(2, TO_MANUAL)) == [REJECTED]
    assert mode(grounded) == PARK


@pytest.mark.parametrize("before", [TO_MANUAL, TO_TRACK])
@pytest.mark.parametrize(("rest", "then"), [(TO_PARK, PARK), (TO_STANDBY, STANDBY), (DISARM, STANDBY)])
def test_what_brings_the_kite_to_rest_has_the_last_word_over_another_station(parked, before, rest, then):
    answers = sorted(results(parked, frame(1, before, 7), frame(1, rest)))
    assert answers == sorted([REJECTED, ACCEPTED])
    assert mode(parked) == then


@pytest.mark.parametrize(("rest", "then"), [(TO_PARK, PARK), (TO_STANDBY, STANDBY), (DISARM, STANDBY)])
def test_what_brings_the_kite_to_rest_acts_in_its_tick_behind_whatever_came_before(parked, rest, then):
    assert results(parked, frame(1, TO_TRACK)) == [ACCEPTED]
    parked.tell(*[set_parameter("INNER_P", 2.0)] * 20)
    parked._waiting.append(frame(2, rest))
    parked.step()
    assert mode(parked) == then
    assert len(parked.autopilot.inbox.orders.requests) == 20 - 6


def test_a_park_on_the_ground_keeps_its_place_among_other_commands(grounded):
    """Nothing is in a hurry there: each is refused in its turn."""
    wishes = [TO_MANUAL, TO_PARK] * 3
    grounded._waiting += [frame(1, wish, station) for station, wish in enumerate(wishes, start=1)]
    acks = of_kind("COMMAND_ACK", grounded.step())
    assert [(ack.target_system, ack.result) for ack in acks] == [(station, REJECTED) for station in range(1, 7)]
    assert set(grounded.texts()) == {"arm first"}


def test_the_last_word_of_a_breath_is_whatever_comes_after_what_brings_the_kite_to_rest(parked):
    """PARK is obeyed first, and has overtaken what came before it, not what comes behind."""
    assert results(parked, frame(1, TO_TRACK, 7), frame(1, TO_PARK), frame(2, TO_MANUAL)) == [
        ACCEPTED, REJECTED, ACCEPTED]
    assert mode(parked) == MANUAL


def test_what_was_overtaken_in_its_tick_counts_as_done_and_is_told_of_when_it_comes_again(parked):
    """So what its station has sent before it is late, as if another station's PARK had come a tick later."""
    assert sorted(results(parked, frame(5, TO_MANUAL, 7), frame(1, TO_PARK))) == sorted([ACCEPTED, REJECTED])
    assert LATE_TEXT not in parked.texts()
    assert results(parked, frame(4, TO_TRACK, 7)) == [REJECTED]
    assert results(parked, frame(5, TO_MANUAL, 7)) == [REJECTED]
    assert mode(parked) == PARK
    assert parked.texts().count(LATE_TEXT) == 2


@pytest.mark.parametrize("breath", [[ARMING, DISARM], [TO_PARK, ARMING, DISARM], [TO_PARK, TO_PARK, ARMING, DISARM]])
def test_an_arm_in_one_breath_with_a_later_disarm_of_another_station_does_not_arm(grounded, breath):
    frames = [frame(1, wish, station) for station, wish in enumerate(breath, start=1)]
    results(grounded, *frames)
    assert mode(grounded) == STANDBY
    assert "armed: PARK" not in grounded.texts()


def test_eight_commands_wait_for_the_check_of_the_eight_and_more_are_rejected_at_once(grounded):
    grounded._waiting += [frame(1, ARMING, station) for station in range(1, 7)]
    assert not of_kind("COMMAND_ACK", grounded.step())
    grounded._waiting += [frame(1, ARMING, station) for station in range(7, 11)]
    rejected = of_kind("COMMAND_ACK", grounded.step())
    assert [(ack.command, ack.target_system, ack.target_component, ack.result) for ack in rejected] == [
        (ARM, 9, 190, REJECTED), (ARM, 10, 190, REJECTED)]
    assert grounded.autopilot.inbox.refused == 2
    accepted = of_kind("COMMAND_ACK", grounded.run(0.5))
    assert [(ack.target_system, ack.result) for ack in accepted] == [(station, ACCEPTED) for station in range(1, 9)]
    assert mode(grounded) == PARK


def test_what_found_no_place_among_the_eight_was_answered_and_does_not_come_back(grounded):
    """A ninth, with number and wish of the second and yet no copy of it: another station sent it."""
    breath = [ARMING, TO_MANUAL, TO_PARK] + [ARMING] * 5
    frames = [frame(1, wish, station) for station, wish in enumerate(breath, start=1)]
    ninth = frame(1, TO_MANUAL, 9)
    grounded._waiting += frames[:6]
    grounded.step()
    grounded._waiting += [*frames[6:], ninth]
    answers = of_kind("COMMAND_ACK", grounded.step())
    assert [(ack.target_system, ack.result) for ack in answers] == [(9, REJECTED)]
    while len(answers) < 4:
        answers += of_kind("COMMAND_ACK", grounded.step())
    assert mode(grounded) == PARK  # as the third asked
    grounded._waiting.append(ninth)
    answers += of_kind("COMMAND_ACK", grounded.run(0.3))
    assert [ack.result for ack in answers if ack.target_system == 9] == [REJECTED, REJECTED]
    assert [ack.target_system for ack in answers if ack.result == ACCEPTED] == list(range(1, 9))
    assert mode(grounded) == PARK


def test_a_copy_that_finds_no_place_says_nothing_of_the_one_that_waits(grounded):
    grounded._waiting += [frame(1, ARMING, station) for station in range(1, 7)]
    grounded.step()
    manual = frame(1, TO_MANUAL, 8)
    grounded._waiting += [frame(1, ARMING, 7), manual, manual]
    (rejected,) = of_kind("COMMAND_ACK", grounded.step())
    assert (rejected.command, rejected.target_system, rejected.result) == (DO_SET_MODE, 8, REJECTED)
    assert [ack.result for ack in of_kind("COMMAND_ACK", grounded.run(0.3))] == [ACCEPTED] * 8
    assert mode(grounded) == MANUAL


def test_curves_that_find_no_place_for_their_check_are_counted(parked):
    """Beside the one that is looked at, twice as many wait as there are parameters of the curve."""
    assert results(parked, frame(1, TO_TRACK)) == [ACCEPTED]
    for station in range(1, 25):
        curve = set_parameter("EIGHT_ELEVATION", 40.0 + 0.125 * station)
        parked._waiting.append(bytes(curve.pack(dialect.MAVLink(None, station, 190))))
    assert len(of_kind("PARAM_VALUE", parked.run(4.0))) == 1 + 2 * len(CURVE_PARAMETERS)
    assert parked.autopilot.inbox.refused == 24 - (1 + 2 * len(CURVE_PARAMETERS))


def test_a_curve_that_waits_for_its_check_is_set_without_one_when_the_kite_leaves_track(parked):
    assert results(parked, frame(1, TO_TRACK)) == [ACCEPTED]
    parked.tell(set_parameter("EIGHT_ELEVATION", 42.0))
    parked.step()
    assert results(parked, frame(2, TO_PARK)) == [ACCEPTED]
    assert parked.value("EIGHT_ELEVATION") == 42.0
