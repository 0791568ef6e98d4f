"""Stories of what goes wrong in flight, with the output that docs/modes.md promises."""

import itertools
import math
from collections.abc import Callable

import pytest
from firmware_bench import (
    MANUAL,
    PARK,
    PERIOD_S,
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
from simulated_storage import SimulatedStorage

from firmware_py.estimation.estimator import Estimator
from firmware_py.modes.mode_machine import ModeMachine
from firmware_py.parameters.persistence import Keeper
from firmware_py.parameters.values import Parameters
from firmware_py.services.inbox import Inbox
from protocol import dialect
from sim_bridge.equipment.sensors import Sample
from sim_bridge.runtimes.tick_output import clock_us

ACCEPTED, REJECTED = dialect.MAV_RESULT_ACCEPTED, dialect.MAV_RESULT_TEMPORARILY_REJECTED
STALE_TICKS = 25  # STALE_TIME, 0.5 s
ARM, DO_SET_MODE = dialect.MAV_CMD_COMPONENT_ARM_DISARM, dialect.MAV_CMD_DO_SET_MODE

Stream = Callable[[int, float], Sample]


def sticks(steering: float) -> dialect.MAVLink_message:
    return dialect.MAVLink_manual_control_message(1, 0, round(steering * 1000), 0, 0, 0)


def mode_command(mode: int) -> dialect.MAVLink_message:
    return command_long(DO_SET_MODE, 1.0, mode)


# What a broken sensor or its link sends, by the tick since it broke and the time; none of it is news of the kite.
STREAMS: dict[str, Stream] = {
    "the same sample": lambda tick, time_s: sample(123_456),
    "one stamp while values move": lambda tick, time_s: sample(123_456, azimuth=0.1 + 0.001 * tick),
    "stamps that go back": lambda tick, time_s: sample(clock_us(time_s - 0.04 * tick)),
    "two stamps in turn": lambda tick, time_s: sample(123_456 + tick % 2),
    "jumps round the sky": lambda tick, time_s: sample(
        clock_us(time_s), azimuth=math.remainder(tick + 1.0, 2 * math.pi)),
    "jumps to and fro": lambda tick, time_s: sample(clock_us(time_s), azimuth=0.1 + tick % 2),
    "jumps up and down, in threes": lambda tick, time_s: sample(
        clock_us(time_s), elevation=(0.7, 1.3, 0.1)[tick % 3]),
}


@pytest.mark.parametrize("mode", [PARK, TRACK])
@pytest.mark.parametrize("name", STREAMS)
def test_a_stream_without_news_is_stale_in_time_and_stays_so(name, mode):
    bench = Bench()
    bench.start(mode)
    broke_s = bench.time_s
    bench.sky = lambda time_s, steering: STREAMS[name](round((time_s - broke_s) / PERIOD_S), time_s)
    bench.run(60.0)
    neutral = [tick for tick, asked in enumerate(bench.steering) if asked == 0.0]
    assert neutral[0] <= STALE_TICKS + 2  # the first of them may have been news
    assert neutral == list(range(neutral[0], len(bench.steering)))
    assert bench.texts() == ["samples stale: steering neutral"]


def test_every_second_sample_wrong_leaves_a_kite_that_flies_on_none_of_them():
    """Right and wrong in turn cannot be told apart: neither is believed."""
    bench = Bench()
    bench.start(TRACK)
    turns = itertools.count()
    bench.sky = lambda time_s, steering: sample(clock_us(time_s), azimuth=0.1 if next(turns) % 2 else -1.0)
    bench.run(1.0)
    assert bench.autopilot.modes.stale


def test_an_outlier_now_and_then_is_flown_past():
    kite = FlyingKite()
    bench = Bench(kite)
    bench.start(TRACK)
    turns = itertools.count()

    def sky(time_s: float, steering: float) -> Sample | None:
        taken = kite(time_s, steering)
        if taken is None or next(turns) % 10:
            return taken
        return (*taken[:1], taken[1] + 1.0, *taken[2:])

    bench.sky = sky
    bench.run(20.0)
    assert bench.texts() == []
    assert bench.autopilot.modes.mode == TRACK


@pytest.mark.parametrize("stood_s", [0.52, 0.9, 5.0, 60.0, 600.0, 1000.0])
def test_a_loop_that_stood_still_knows_that_its_samples_are_old(stood_s):
    """A new sample comes with the very tick that finds out; the clock's difference changes its sign after 537 s."""
    bench = Bench()
    bench.start(TRACK)
    bench.run(0.1)
    bench.time_s += stood_s - PERIOD_S
    bench.step()
    assert bench.steering[-1] == 0.0
    bench.run(0.48)
    assert set(bench.steering[-25:]) == {0.0}
    bench.run(0.1)
    assert bench.texts() == ["samples stale: steering neutral", "samples fresh again: PARK"]


def test_a_loop_that_stood_still_for_less_flies_on():
    bench = Bench()
    bench.start(TRACK)
    bench.run(0.1)
    bench.time_s += 0.4
    bench.run(0.5)
    assert (bench.texts(), bench.mode) == ([], TRACK)


def test_samples_are_fresh_again_with_one_that_is_accepted_half_a_second_after_another():
    bench = Bench()
    bench.start(PARK)
    bench.sky = None
    bench.run(1.0)
    arriving = (0, 20, 26)  # ticks: half a second after the first none comes
    taken = hovering()
    for tick in range(27):
        bench.sky = taken if tick in arriving else None
        bench.step()
        assert bench.autopilot.modes.stale == (tick < 26)
    bench.run(0.1)
    assert bench.texts()[-1] == "samples fresh again: PARK"


@pytest.mark.parametrize("resume", [0.0, 1.0])
def test_the_operators_park_is_taken_while_samples_are_stale_and_kept(resume):
    bench = Bench()
    bench.set(RESUME_TRACK=resume)
    bench.start(TRACK)
    bench.sky = None
    bench.run(1.0)
    assert bench.change_mode(PARK) == ACCEPTED
    assert bench.mode == PARK
    assert bench.steering[-1] == 0.0
    bench.sky = hovering(course=0.5)
    bench.run(0.6)
    assert bench.mode == PARK
    assert bench.steering[-1] < 0.0  # it parks as soon as it can
    assert bench.texts()[-1] == "samples fresh again: PARK"


def test_a_pilot_who_sees_the_kite_steers_it_though_samples_are_stale():
    bench = Bench()
    bench.start(TRACK)
    bench.sky = None
    bench.run(1.0)
    assert bench.change_mode(MANUAL) == ACCEPTED
    for wanted in (0.5, -0.25, 1.0):
        bench.tell(sticks(wanted))
        bench.run(0.06)
        assert bench.steering[-1] == pytest.approx(wanted, abs=1e-7)
    bench.sky = hovering()
    for _ in range(10):
        bench.tell(sticks(0.125))
        bench.run(0.1)
    assert (bench.mode, bench.steering[-1]) == (MANUAL, 0.125)  # and goes on when they are back
    bench.sky = None
    for _ in range(10):
        bench.tell(sticks(0.125))
        bench.run(0.1)
    assert bench.steering[-1] == 0.125
    assert bench.texts()[-1] == "samples stale: steering is the pilot's"
    bench.run(0.6)
    assert (bench.mode, bench.steering[-1]) == (PARK, 0.0)
    assert bench.texts()[-1] == "no MANUAL_CONTROL: PARK"


def test_a_silence_acts_once_and_acts_where_the_time_is_set_during_it():
    bench = Bench()
    bench.start(TRACK)
    bench.tell(station_heartbeat())
    bench.run(3.0)
    bench._waiting.append(set_parameter("GCS_LOST_TIME", 2.0).pack(bench._station))  # no sign of life
    bench.run(5.0)
    assert (bench.mode, bench.texts()) == (PARK, ["ground station silent: PARK"])
    (text,) = of_kind("STATUSTEXT", [message for _, message in bench.heard])
    assert text.severity == dialect.MAV_SEVERITY_WARNING


def test_a_refusal_to_track_tells_that_samples_are_stale():
    bench = Bench()
    bench.start(PARK)
    bench.sky = None
    bench.run(0.6)
    assert bench.change_mode(TRACK) == REJECTED
    bench.step()
    assert bench.texts()[-1] == "samples are stale"


def test_the_newest_of_too_many_parks_takes_the_last_place_and_leaves_those_of_disarms():
    inbox = Inbox()
    park, disarm = (0, PARK, 0, 0, 0, 0, 0, DO_SET_MODE, 1, 1), (0.0, 0, 0, 0, 0, 0, 0, ARM, 1, 1)
    for system in range(1, 7):
        inbox.put(dialect.MAVLINK_MSG_ID_COMMAND_LONG, park, system, 190)
    assert inbox.refused == 2
    inbox.put(dialect.MAVLINK_MSG_ID_COMMAND_LONG, disarm, 99, 190)
    assert inbox.refused == 2
    assert [urgent.command.system for urgent in inbox.take_urgent()] == [1, 2, 3, 6, 99]


def test_manual_asked_for_again_leaves_the_sticks_where_they_are():
    bench = Bench()
    bench.start(MANUAL)
    bench.tell(sticks(0.5))
    bench.run(0.1)
    bench.steering.clear()
    assert bench.change_mode(MANUAL) == ACCEPTED
    bench.run(0.1)
    assert set(bench.steering) == {0.5}


def test_a_silence_of_ten_minutes_in_park_does_not_count_as_none():
    bench = Bench()
    bench.set(GCS_LOST_TIME=2.0)
    bench.start(PARK)
    bench.tell(station_heartbeat())
    bench.run(3.0)
    assert bench.texts() == ["ground station silent: PARK"]
    bench.period_s = 0.25
    bench.run(600.0)
    assert bench.texts() == ["ground station silent: PARK"]
    bench.period_s = PERIOD_S
    bench.change_mode(TRACK)
    bench.run(2.5)
    assert bench.mode == PARK
    assert bench.texts()[-1] == "ground station silent: PARK"


@pytest.mark.parametrize("jump_s", [540.0, 700.0, 1000.0, 1070.0])
def test_no_jump_of_the_clock_ends_a_silence(jump_s):
    bench = Bench()
    bench.set(GCS_LOST_TIME=2.0)
    bench.start(TRACK)
    bench.tell(station_heartbeat())
    bench.run(1.0)
    bench.time_s += jump_s
    bench.step()
    bench.step()
    assert bench.mode == PARK
    assert sorted(bench.texts()) == ["ground station silent: PARK", "samples stale: steering neutral"]


def test_neutral_is_reached_at_once_however_slow_steering_may_be():
    bench = Bench(hovering(course=2.0))
    bench.start(TRACK)
    bench.run(0.5)
    assert abs(bench.steering[-1]) > 0.1
    bench.set(STEER_RATE=0.03125)
    bench.sky = None
    bench.run(0.54)
    assert bench.steering[-1] == 0.0
    bench.sky = hovering(course=2.0)
    bench.run(20.0)
    assert abs(bench.steering[-1]) > 0.1
    bench.disarm()
    bench.step()
    assert bench.steering[-1] == 0.0


def test_a_lowered_limit_holds_at_once():
    bench = Bench(hovering(course=2.0))
    bench.set(INNER_P=20.0)
    bench.start(PARK)
    bench.run(0.5)
    assert abs(bench.steering[-1]) == 1.0
    bench.set(STEER_RATE=0.0625)
    bench.set(STEER_MAX=0.25)
    bench.step()
    assert abs(bench.steering[-1]) == 0.25


def test_a_flood_of_parks_for_us_does_not_hold_a_disarm_up():
    bench = Bench()
    bench.start(TRACK)
    spoofed = [dialect.MAVLink(None, system, 1) for system in range(10, 50)]
    bench.sky = FlyingKite()
    for _ in range(3):
        bench._waiting += [command_long(DO_SET_MODE, 1.0, PARK).pack(station) for station in spoofed]
        bench.step()
    bench._waiting += [command_long(DO_SET_MODE, 1.0, PARK).pack(station) for station in spoofed]
    bench.tell(command_long(ARM, 0.0))
    bench._waiting += [command_long(DO_SET_MODE, 1.0, PARK).pack(station) for station in spoofed]
    bench.step()
    assert bench.autopilot.modes.mode == STANDBY
    bench.step()
    assert bench.steering[-1] == 0.0


def test_the_history_of_steering_keeps_time_with_a_loop_that_is_late():
    """Ticks of 1.4 periods: over a second, fifty of them were modelled, not thirty-six."""
    bench = Bench(FlyingKite())
    bench.start(PARK)
    before = bench.autopilot.history._count
    bench.period_s = 0.028
    bench.run(1.4)
    assert bench.autopilot.history._count - before == pytest.approx(70, abs=1)


def test_a_station_that_sets_on_and_on_does_not_wear_the_flash_out():
    parameters, storage, said = Parameters(), SimulatedStorage(), []
    modes = ModeMachine(parameters, Estimator(), lambda severity, text: None)
    keeper = Keeper(parameters, modes, storage, None, lambda severity, text: said.append(text))
    keeper.start(None)
    for second in range(600):
        parameters.set(0, 2.0 + second % 7)
        for _ in range(60):
            keeper.update(20_000, 0)
    writes = [name for what, name in storage.log if what == "write"]
    assert len(writes) <= 8 + 600 * 1.2 / 60.0
    assert "saving parameters later to spare the flash" in said
    for _ in range(4000):
        keeper.update(20_000, 0)
    stored = Parameters()
    assert keeper.store and keeper.store.load(stored).found  # what was set last is not lost
    assert stored.values == parameters.values
