"""Stories of a flight: arming, modes, and what is done when something is missing."""

import math
from typing import Any

import pytest
from firmware_bench import (
    ARM,
    DO_SET_MODE,
    EVERYTHING,
    MANUAL,
    PARK,
    PERIOD_S,
    REQUEST_MESSAGE,
    STANDBY,
    TRACK,
    Bench,
    FlyingKite,
    command_long,
    hovering,
    of_kind,
    sample,
    set_parameter,
    station_heartbeat,
)

from protocol import dialect
from sim_bridge.runtimes.tick_output import clock_us

ACCEPTED, DENIED = dialect.MAV_RESULT_ACCEPTED, dialect.MAV_RESULT_DENIED
REJECTED, UNSUPPORTED = dialect.MAV_RESULT_TEMPORARILY_REJECTED, dialect.MAV_RESULT_UNSUPPORTED


def sticks(steering: float, target: int = 1) -> dialect.MAVLink_message:
    return dialect.MAVLink_manual_control_message(target, 0, round(steering * 1000), 0, 0, 0)


def last_state(bench: Bench) -> Any:
    return of_kind("KITE_STATE", [message for _, message in bench.heard])[-1]


def run_until(bench: Bench, mode: int, at_most_s: float) -> float:
    """Run until `mode` is entered; return how long that took [s]."""
    start = bench.time_s
    while bench.time_s < start + at_most_s:
        bench.step()
        if bench.mode == mode:
            return bench.time_s - PERIOD_S - start
    raise AssertionError(f"still in mode {bench.mode} after {at_most_s} s: {bench.texts()}")


def test_a_flight_from_standby_to_standby():
    bench = Bench(FlyingKite(course=1.2))
    bench.run(0.5)
    assert bench.mode == STANDBY
    assert set(bench.steering) == {0.0}
    assert bench.change_mode(TRACK) == REJECTED

    assert bench.arm() == ACCEPTED
    assert bench.mode == PARK
    bench.run(1.5)
    assert abs(last_state(bench).course) < 0.3  # straight up
    assert last_state(bench).target_course == 0.0

    assert bench.change_mode(TRACK) == ACCEPTED
    assert bench.mode == TRACK
    bench.run(40.0)
    states = of_kind("KITE_STATE", [message for _, message in bench.heard])[-1000:]
    assert max(abs(state.cross_track) for state in states) < 0.2
    assert min(state.azimuth for state in states) < -0.4  # to both ends of the eight
    assert max(state.azimuth for state in states) > 0.4

    assert bench.disarm() == ACCEPTED
    bench.run(0.1)
    assert (bench.mode, bench.steering[-1]) == (STANDBY, 0.0)
    assert bench.texts() == ["arm first", "armed: PARK", "mode TRACK", "disarmed: STANDBY"]


def test_heartbeats_say_whether_it_is_armed():
    bench = Bench()
    seen = {}
    for mode, change in ((STANDBY, None), (PARK, bench.arm), (TRACK, lambda: bench.change_mode(TRACK))):
        if change:
            change()
        bench.run(1.1)
        heartbeat = of_kind("HEARTBEAT", [message for _, message in bench.heard])[-1]
        assert heartbeat.custom_mode == mode
        assert heartbeat.type == dialect.MAV_TYPE_KITE
        seen[mode] = (heartbeat.base_mode, heartbeat.system_status)
    custom, armed = dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, dialect.MAV_MODE_FLAG_SAFETY_ARMED
    assert seen[STANDBY] == (custom, dialect.MAV_STATE_STANDBY)
    assert seen[PARK] == seen[TRACK] == (custom | armed, dialect.MAV_STATE_ACTIVE)


def test_no_arming_without_samples():
    bench = Bench()
    bench.sky = None
    bench.run(0.2)
    assert bench.arm() == REJECTED
    bench.run(0.1)
    assert bench.texts() == ["no samples from the kite"]
    assert bench.mode == STANDBY

    bench.sky = hovering()
    bench.run(0.1)
    assert bench.arm() == ACCEPTED

    bench.disarm()
    bench.sky = None
    bench.run(0.6)
    assert bench.arm() == REJECTED  # the ones from before are stale
    bench.sky = hovering(valid=EVERYTHING & ~dialect.KITE_VALID_AZIMUTH)
    bench.run(0.2)
    assert bench.arm() == REJECTED  # these ones are no good


def test_commands_are_idempotent_and_every_copy_is_acknowledged():
    bench = Bench()
    bench.run(0.1)
    for command, mode in ((command_long(ARM, 1.0), PARK), (command_long(DO_SET_MODE, 1.0, TRACK), TRACK),
                          (command_long(ARM, 1.0), TRACK), (command_long(ARM, 0.0), STANDBY)):
        before = len(bench.texts())
        bench.tell(command, command, command)
        acknowledged = of_kind("COMMAND_ACK", bench.run(0.4))
        assert [(ack.command, ack.result) for ack in acknowledged] == [(command.command, ACCEPTED)] * 3  # type: ignore[attr-defined]
        assert bench.mode == mode
        assert len(bench.texts()) <= before + 1
    assert bench.texts() == ["armed: PARK", "mode TRACK", "disarmed: STANDBY"]


def test_a_copy_of_the_command_to_track_is_good_after_a_refused_parameter():
    bench = Bench()
    bench.start(TRACK)
    bench.tell(set_parameter("EIGHT_LEAST_EL", 40.0))
    bench.run(0.3)
    assert "minimum is 40.0" in bench.texts()[0]
    assert bench.change_mode(TRACK) == ACCEPTED
    assert bench.mode == TRACK


@pytest.mark.parametrize(
    ("command", "first", "second", "result"),
    [
        (410, 0.0, 0.0, UNSUPPORTED), (511, 245.0, 1e6, UNSUPPORTED), (0, 0.0, 0.0, UNSUPPORTED),
        (65535, math.nan, math.nan, UNSUPPORTED), (REQUEST_MESSAGE, 242.0, 0.0, UNSUPPORTED),
        (REQUEST_MESSAGE, math.nan, 0.0, UNSUPPORTED), (ARM, 2.0, 0.0, DENIED), (ARM, math.nan, 0.0, DENIED),
        (ARM, 0.5, 0.0, DENIED), (DO_SET_MODE, 1.0, math.nan, DENIED), (DO_SET_MODE, 1.0, math.inf, DENIED),
        (DO_SET_MODE, 1.0, -1.0, DENIED), (DO_SET_MODE, 1.0, 3e38, DENIED), (DO_SET_MODE, 1.0, 2.5, DENIED),
        (DO_SET_MODE, 1.0, 256.0, DENIED), (DO_SET_MODE, 1.0, 4.0, REJECTED), (DO_SET_MODE, 1.0, 255.0, REJECTED),
    ],
)
def test_what_cannot_be_done_is_refused_and_changes_nothing(command, first, second, result):
    bench = Bench()
    bench.start(TRACK)
    assert bench.command(command, first, second) == result
    assert bench.mode == TRACK


def test_a_mode_that_there_is_not_is_refused_with_the_reason():
    bench = Bench()
    bench.start(PARK)
    assert bench.change_mode(9) == REJECTED
    bench.step()
    assert (bench.mode, bench.texts()) == (PARK, ["no such mode"])


def test_a_mode_between_two_modes_does_not_get_past_the_curves_check():
    bench = Bench()
    bench.start(PARK)
    bench.set(EIGHT_LEAST_EL=40.0)
    for almost in (TRACK, TRACK + 0.5, TRACK + 2.0**-20):
        assert bench.change_mode(almost) in (REJECTED, DENIED)
        assert bench.mode == PARK


def test_commands_to_others_are_not_for_us():
    bench = Bench()
    bench.run(0.1)
    for system in (2, 255):
        assert of_kind("COMMAND_ACK", bench.ask(command_long(ARM, 1.0, system=system))) == []
    camera = dialect.MAVLink_command_long_message(1, 100, ARM, 0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert of_kind("COMMAND_ACK", bench.ask(camera)) == []
    assert bench.mode == STANDBY
    everybody = bench.ask_for("COMMAND_ACK", command_long(ARM, 1.0, system=0))
    assert everybody.result == ACCEPTED


@pytest.mark.parametrize("mode", [PARK, TRACK])
@pytest.mark.parametrize("stale_time", [0.0625, 0.5, 2.0])
def test_without_samples_steering_goes_neutral_within_stale_time_and_a_tick(mode, stale_time):
    bench = Bench()
    bench.set(STALE_TIME=stale_time)
    bench.start(mode)
    assert bench.steering == []
    last_sample_s = bench.time_s - PERIOD_S
    bench.sky = None
    bench.run(stale_time + 0.2)
    neutral = [last_sample_s + (1 + tick) * PERIOD_S for tick, asked in enumerate(bench.steering) if asked == 0.0]
    assert last_sample_s + stale_time < neutral[0] <= last_sample_s + stale_time + PERIOD_S + 1e-9
    assert len(neutral) == sum(time_s >= neutral[0] - 1e-9 for time_s in neutral)
    assert bench.texts() == ["samples stale: steering neutral"]
    (text,) = of_kind("STATUSTEXT", [message for _, message in bench.heard])
    assert text.severity == dialect.MAV_SEVERITY_CRITICAL
    assert last_state(bench).status & dialect.KITE_STATUS_STALE
    assert bench.mode == mode  # until samples are fresh again
    assert bench.change_mode(TRACK) == REJECTED
    bench.run(1.1)
    assert of_kind("HEARTBEAT", [m for _, m in bench.heard])[-1].system_status == dialect.MAV_STATE_CRITICAL


@pytest.mark.parametrize(("resume", "back"), [(0.0, PARK), (1.0, TRACK)])
def test_samples_must_be_fresh_for_half_a_second_before_the_kite_is_steered_again(resume, back):
    bench = Bench()
    bench.set(RESUME_TRACK=resume)
    bench.start(TRACK)
    bench.sky = None
    bench.run(1.0)

    once = hovering()
    for _ in range(3):  # a sample now and then does not count
        bench.sky = once
        bench.step()
        bench.sky = None
        bench.run(0.7)
    bench.steering.clear()
    bench.sky = hovering(azimuth=-0.6)  # and the kite may be anywhere by now
    bench.run(0.5)
    assert set(bench.steering) == {0.0}
    bench.step()
    assert bench.steering[-1] != 0.0
    assert bench.mode == back
    assert bench.texts()[-1] == f"samples fresh again: {'TRACK' if back == TRACK else 'PARK'}"
    assert not last_state(bench).status & dialect.KITE_STATUS_STALE


def test_a_gap_shorter_than_stale_time_is_nothing():
    bench = Bench()
    bench.start(TRACK)
    bench.run(0.1)
    steady = bench.steering[-1]
    bench.sky = None
    bench.run(0.48)
    bench.sky = hovering()
    bench.run(0.5)
    assert set(bench.steering) == {steady}
    assert bench.texts() == []


def test_twenty_minutes_without_samples_stay_neutral():
    """The clock wraps after eighteen; half of it is where a difference of times changes its sign."""
    bench = Bench()
    bench.set(RESUME_TRACK=1.0)
    bench.start(TRACK)
    bench.sky = None
    bench.run(0.6)
    bench.steering.clear()
    bench.period_s = 0.25
    bench.run(1200.0)
    assert set(bench.steering) == {0.0}
    assert bench.texts() == ["samples stale: steering neutral"]


def test_disarming_works_without_samples_and_arming_again_does_not():
    bench = Bench()
    bench.start(TRACK)
    bench.sky = None
    bench.run(0.6)
    assert bench.disarm() == ACCEPTED
    assert bench.arm() == REJECTED
    bench.sky = hovering()
    bench.run(1.0)
    assert bench.mode == STANDBY
    assert bench.arm() == ACCEPTED
    assert bench.mode == PARK


def test_a_kite_that_was_disarmed_while_stale_is_steered_at_once_when_it_is_armed_again():
    bench = Bench()
    bench.start(TRACK)
    bench.sky = None
    bench.run(0.6)
    bench.disarm()
    bench.sky = hovering()
    bench.run(1.0)
    assert not last_state(bench).status & dialect.KITE_STATUS_STALE
    bench.heard.clear()
    assert bench.arm() == ACCEPTED
    bench.step()
    assert bench.steering[-1] != 0.0
    assert bench.texts() == ["armed: PARK"]


def test_without_a_pilot_manual_lasts_for_manual_time_and_no_tick_longer_or_shorter():
    bench = Bench()
    bench.set(MANUAL_TIME=0.5)
    bench.start(PARK)
    bench.tell(command_long(DO_SET_MODE, 1.0, MANUAL))
    bench.step()
    modes = []
    for _ in range(27):
        bench.step()
        modes.append(bench.autopilot.modes.mode)
    assert modes == [MANUAL] * 25 + [PARK] * 2


def test_manual_follows_the_sticks_and_gives_way_to_park():
    bench = Bench()
    bench.start(MANUAL)
    assert bench.steering == []
    for wanted in (0.25, -1.0, 1.0, 0.0, 0.001, -0.5):
        bench.tell(sticks(wanted))
        bench.run(0.06)
        assert bench.steering[-1] == pytest.approx(wanted, abs=1e-7)
    told_s = bench.time_s - 0.06
    bench.run(0.4)
    assert bench.steering[-1] == -0.5
    assert bench.mode == MANUAL
    gone_s = bench.time_s + run_until(bench, PARK, 0.5)
    assert told_s + 0.5 < gone_s <= told_s + 0.5 + 2 * PERIOD_S + 1e-9
    assert bench.texts() == ["no MANUAL_CONTROL: PARK"]


def test_sticks_out_of_range_or_for_others_are_not_followed():
    bench = Bench()
    bench.start(MANUAL)
    bench.tell(sticks(0.25))
    bench.run(0.06)
    for wrong in (sticks(1.001), sticks(-1.001), sticks(32.767), sticks(0.5, target=2)):
        bench.tell(wrong)
        bench.run(0.06)
    assert bench.steering[-12:] == [0.25] * 12
    bench.run(0.3)  # nor do they keep MANUAL alive
    assert bench.mode == PARK


def test_manual_begins_neutral_whatever_the_sticks_said_before():
    bench = Bench()
    bench.start(PARK)
    bench.tell(sticks(1.0))
    bench.run(0.1)
    bench.steering.clear()
    bench.change_mode(MANUAL)
    bench.run(0.2)
    assert bench.steering[-9:] == [0.0] * 9
    bench.tell(sticks(0.75))
    bench.run(0.1)
    assert bench.steering[-1] == 0.75


@pytest.mark.parametrize("mode", [MANUAL, TRACK])
def test_silence_of_a_ground_station_that_was_heard_parks_the_kite(mode):
    bench = Bench()
    bench.set(GCS_LOST_TIME=2.0, MANUAL_TIME=5.0)
    bench.start(mode)
    for _ in range(5):
        bench.tell(station_heartbeat(), sticks(0.0))
        bench.run(1.0)
    assert bench.mode == mode
    silent_s = bench.time_s - 1.0
    parked_s = bench.time_s + run_until(bench, PARK, 3.0)
    assert silent_s + 2.0 < parked_s <= silent_s + 2.0 + 2 * PERIOD_S + 1e-9
    assert bench.texts() == ["ground station silent: PARK"]

    commanded_s = bench.time_s  # an operator whose heartbeats do not come through is heard all the same, once
    bench.change_mode(mode)
    parked_s = bench.time_s + run_until(bench, PARK, 3.0)
    assert 2.0 - 2 * PERIOD_S <= parked_s - commanded_s <= 2.0 + 2 * PERIOD_S + 1e-9


def test_silence_of_ground_stations_means_nothing_if_none_was_heard_or_the_time_is_zero():
    bench = Bench()
    bench.set(GCS_LOST_TIME=2.0)
    bench.start(TRACK)
    other_kite = dialect.MAVLink_heartbeat_message(dialect.MAV_TYPE_KITE, 0, 0, 0, 4, 3)
    bench.tell(other_kite)
    bench.run(5.0)
    assert bench.mode == TRACK

    bench = Bench()
    bench.start(TRACK)
    bench.tell(station_heartbeat())
    bench.run(5.0)
    assert bench.mode == TRACK


def test_a_kite_that_comes_too_low_is_parked():
    bench = Bench()
    bench.set(PARK_ELEVATION=10.0)
    bench.start(TRACK)
    elevation = [0.7]
    bench.sky = lambda time_s, steering: sample(clock_us(time_s), elevation=elevation[0])
    while elevation[0] > math.radians(10.0):
        bench.step()
        assert bench.mode == TRACK
        elevation[0] -= 0.01
    bench.step()
    bench.step()
    assert bench.mode == PARK
    assert bench.texts() == ["too low: PARK"]
    bench.run(1.0)
    assert bench.mode == PARK


def test_no_height_is_too_low_where_the_parameter_is_off():
    bench = Bench(hovering(elevation=-0.1))
    bench.set(PARK_ELEVATION=0.0)
    bench.start(TRACK)
    bench.run(0.2)
    assert bench.mode == TRACK


def test_track_aims_at_the_curve_at_once_though_no_new_sample_has_come():
    """Samples at 10 Hz, the mode changes between two of them: no tick is steered by an old or an empty target."""
    bench = Bench(FlyingKite(every=5))
    bench.run(1.0)
    bench.arm()
    for _ in range(3):
        bench.change_mode(TRACK)
        bench.heard.clear()
        bench.run(0.16)
        states = of_kind("KITE_STATE", [message for _, message in bench.heard])
        targets = [state.target_course for state in states if state.mode == TRACK]
        assert len(targets) >= 7
        assert all(abs(math.remainder(target - targets[-1], 2 * math.pi)) < 0.5 for target in targets)
        assert 0.0 not in targets
        bench.change_mode(PARK)
        bench.run(1.03)
