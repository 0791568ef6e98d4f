"""Parameters over the real wire: what is taken, what is refused and how, and when a new value takes effect."""

import math
import struct

import numpy as np
import pytest
from firmware_bench import (
    COURSE,
    EVERYTHING,
    NAMES,
    POSITION,
    Bench,
    FlyingKite,
    command_long,
    hovering,
    of_kind,
    set_parameter,
)

from protocol import dialect
from protocol.parameter_table import load_parameters
from protocol.single_precision import float32

TABLE = load_parameters()
NO_DISTANCE = EVERYTHING & ~dialect.KITE_VALID_DISTANCE
EACH_PARAMETER = pytest.mark.parametrize("name", TABLE)


def neighbours(value: float) -> list[float]:
    """`value` in float32 with one step to either side."""
    here = np.float32(value)
    return [float(np.nextafter(here, np.float32(-np.inf))), value, float(np.nextafter(here, np.float32(np.inf)))]


def candidates(name: str) -> list[float]:
    """Every boundary and one step to either side, steps between steps, and what is no number at all."""
    parameter = TABLE[name]
    values = neighbours(parameter.least) + neighbours(parameter.greatest) + neighbours(parameter.default)
    if parameter.step:
        values += [*neighbours(parameter.least + parameter.step), parameter.least + parameter.step / 2, 0.0]
    return [*values, math.nan, math.inf, -math.inf, 3.4028234663852886e38, float32(-1e38)]


def expected_error(name: str, value: float, armed: bool = False) -> int | None:
    """PARAM_ERROR's code by the contract's own table, or None."""
    if TABLE[name].read_only:
        return dialect.MAV_PARAM_ERROR_READ_ONLY
    if TABLE[name].problem_with(value):
        return dialect.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE
    return dialect.MAV_PARAM_ERROR_PERMISSION_DENIED if TABLE[name].disarmed_only and armed else None


def answers(bench: Bench, name: str, value: float) -> list[tuple]:
    """What comes back when a parameter is set: PARAM_ERROR and PARAM_VALUE in their order.

    In TRACK the curve is checked before, which takes some ticks.
    """
    bench.tell(set_parameter(name, value))
    messages = bench.run(0.4)
    return [
        (m.get_type(), m.param_id, m.error if m.get_type() == "PARAM_ERROR" else m.param_value)
        for m in messages if m.get_type() in ("PARAM_ERROR", "PARAM_VALUE")]


def assert_refused(bench: Bench, name: str, value: float, error: int) -> None:
    """The error comes first, then the present value, and nothing has changed."""
    before = list(bench.autopilot.parameters.values)
    assert answers(bench, name, value) == [("PARAM_ERROR", name, error), ("PARAM_VALUE", name, bench.value(name))]
    assert bench.autopilot.parameters.values == before


@EACH_PARAMETER
def test_boundaries_and_one_step_to_either_side(name):
    bench = Bench()
    taken = refused = 0
    for value in candidates(name):
        error = expected_error(name, value)
        if error is not None:
            assert_refused(bench, name, value, error)
            refused += 1
        else:
            assert answers(bench, name, value) == [("PARAM_VALUE", name, value)]
            assert struct.pack("<f", bench.value(name)) == struct.pack("<f", value)
            taken += 1
    assert refused > 3
    assert (taken == 0) == TABLE[name].read_only


def test_the_directions_between_minus_one_and_one_are_refused():
    """The one step that is not 1: a share of it would make the kite fly along no direction at all."""
    bench = Bench()
    bench.set(EIGHT_DIRECTION=-1.0)
    for value in (0.0, -0.5, 0.5, *neighbours(-1.0)[::2], neighbours(1.0)[0]):
        assert_refused(bench, "EIGHT_DIRECTION", value, dialect.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE)
    bench.set(EIGHT_DIRECTION=1.0)


@pytest.mark.parametrize("name", ["LOOP_HZ", "SYSTEM_ID"])
def test_disarmed_only(name):
    assert [n for n in TABLE if TABLE[n].disarmed_only] == ["LOOP_HZ", "SYSTEM_ID"]
    bench = Bench()
    bench.start(dialect.KITE_MODE_PARK)
    for value in candidates(name):
        error = expected_error(name, value, armed=True)
        assert error is not None
        assert_refused(bench, name, value, error)
    bench.disarm()
    bench.set(**{name: TABLE[name].greatest})


@pytest.mark.parametrize("name", ["NO_SUCH_NAME", "INNER_P2", "INNER_", "inner_p", "X" * 16, ""])
def test_an_unknown_name_is_refused_and_there_is_no_value_to_tell(name):
    bench = Bench()
    before = list(bench.autopilot.parameters.values)
    assert answers(bench, name, 1.0) == [("PARAM_ERROR", name, dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST)]
    assert bench.autopilot.parameters.values == before


def test_names_of_sixteen_letters_and_padding_do_not_confuse():
    bench = Bench()
    padded = dialect.MAVLink_param_set_message(1, 1, b"OUTER_L\0garbage", 2.0, dialect.MAV_PARAM_TYPE_REAL32)
    assert [m.param_id for m in of_kind("PARAM_VALUE", bench.ask(padded))] == ["OUTER_L"]
    assert bench.value("OUTER_L") == 2.0


def test_only_this_kite_listens():
    bench = Bench()
    bench.set(SYSTEM_ID=7.0)
    assert of_kind("PARAM_VALUE", bench.ask(set_parameter("INNER_P", 2.0, system=1))) == []
    assert of_kind("PARAM_VALUE", bench.ask(set_parameter("INNER_P", 2.0, system=8))) == []
    assert bench.value("INNER_P") == 1.5
    (answer,) = of_kind("PARAM_VALUE", bench.ask(set_parameter("INNER_P", 2.0, system=7)))
    assert (answer.param_value, answer.get_srcSystem()) == (2.0, 7)


def test_reading_by_name_by_index_and_past_the_end():
    bench = Bench()
    for index, name in enumerate(NAMES):
        for asked in ((b"", index), (name.encode(), -1)):
            (value,) = of_kind("PARAM_VALUE", bench.ask(dialect.MAVLink_param_request_read_message(1, 1, *asked)))
            assert (value.param_id, value.param_index, value.param_count) == (name, index, len(NAMES))
            assert value.param_value == TABLE[name].default
            assert value.param_type == dialect.MAV_PARAM_TYPE_REAL32
    for asked in ((b"", len(NAMES)), (b"", 32767), (b"NO_SUCH", -1), (b"", -32768)):
        (error,) = of_kind("PARAM_ERROR", bench.ask(dialect.MAVLink_param_request_read_message(1, 1, *asked)))
        assert error.error == dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST
        assert (error.target_system, error.target_component) == (255, 190)


# What makes the default eight unflyable, by each of the rules, and a word of the reason.
UNFLYABLE = [
    ("EIGHT_LEAST_EL", 33.0, "eight goes down to 32.0 deg, minimum is 33.0"),
    ("EIGHT_ELEVATION", 17.0, "goes down to 9.0 deg"),
    ("EIGHT_ELEVATION", 80.0, "over the zenith"),
    ("WINDOW_ANGLE", 30.0, "leaves the wind window of 30 deg"),
    ("EIGHT_AZIMUTH", 60.0, "leaves the wind window"),
    ("EIGHT_HALF_W", 1.0, "kite manages 2.29"),
    ("TURN_K", 0.0625, "kite manages 9.17"),
    ("STEER_MAX", 0.25, "kite manages 9.17"),
]


@pytest.mark.parametrize(("name", "value", "reason"), UNFLYABLE)
def test_a_curve_that_cannot_be_flown_is_refused_in_flight_and_on_arming(name, value, reason):
    bench = Bench()
    bench.start(dialect.KITE_MODE_TRACK)
    assert_refused(bench, name, value, dialect.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE)
    (text,) = bench.texts()
    assert reason in text

    bench.disarm()
    bench.set(**{name: value})  # on the ground a curve may be changed one parameter at a time
    bench.heard.clear()
    assert bench.arm() == dialect.MAV_RESULT_TEMPORARILY_REJECTED
    bench.run(0.1)
    assert bench.mode == dialect.KITE_MODE_STANDBY
    assert bench.texts() == [text]


def test_the_parameter_line_length_counts_where_no_distance_is_measured():
    bench = Bench(hovering(valid=NO_DISTANCE))
    bench.start(dialect.KITE_MODE_TRACK)
    assert_refused(bench, "LINE_LENGTH", 20.0, dialect.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE)

    bench = Bench(hovering(distance=100.0))
    bench.start(dialect.KITE_MODE_TRACK)
    bench.set(LINE_LENGTH=20.0)


def test_a_curve_is_judged_with_all_that_was_set_in_the_same_tick():
    """A request meets what the ones before it have set, though the loop has not taken that over yet."""
    bench = Bench()
    bench.step()
    arm = command_long(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)
    for elevation, result in ((17.0, dialect.MAV_RESULT_TEMPORARILY_REJECTED), (18.0, dialect.MAV_RESULT_ACCEPTED)):
        bench.tell(set_parameter("EIGHT_ELEVATION", elevation), arm)
        assert [m.result for m in of_kind("COMMAND_ACK", bench.run(0.4))] == [result]

    bench.change_mode(dialect.KITE_MODE_TRACK)
    for half_height, least, held in ((7.0, 11.0, 11.0), (6.5, 12.0, 11.0)):  # one makes room for the other, or does not
        bench.tell(set_parameter("EIGHT_HALF_H", half_height), set_parameter("EIGHT_LEAST_EL", least))
        bench.run(0.6)
        assert (bench.value("EIGHT_HALF_H"), bench.value("EIGHT_LEAST_EL")) == (half_height, held)


def test_out_of_an_eight_that_got_unflyable_there_is_a_way():
    """The line was reeled in: one parameter may mend it at once, several may by way of PARK."""
    bench = Bench()
    bench.start(dialect.KITE_MODE_TRACK)
    bench.sky = hovering(distance=40.5)
    bench.step()
    assert_refused(bench, "EIGHT_HALF_W", 30.5, dialect.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE)
    bench.set(EIGHT_HALF_H=7.0)

    bench.sky = hovering(distance=30.0)
    bench.step()
    bench.change_mode(dialect.KITE_MODE_PARK)
    bench.set(EIGHT_HALF_W=45.0, EIGHT_HALF_H=9.0)
    assert bench.change_mode(dialect.KITE_MODE_TRACK) == dialect.MAV_RESULT_ACCEPTED


def test_a_gain_takes_effect_whole_between_two_ticks():
    """A hovering kite in PARK with a turning-angle error of -0.5 rad: steering is P times that over K Va."""
    bench = Bench(hovering(course=0.5, airspeed=20.0, valid=POSITION | COURSE | dialect.KITE_VALID_AIRSPEED))
    bench.start(dialect.KITE_MODE_PARK)
    bench.set(SPEED_MIN=0.0)
    bench.run(0.1)
    bench.ask(set_parameter("INNER_P", 3.0), set_parameter("TURN_K", 0.5), set_parameter("TURN_OFFSET", 0.25))
    bench.step()
    bench.step()
    before = 1.5 * -0.5 / (0.25 * 20.0)
    after = (3.0 * -0.5 - 0.25) / (0.5 * 20.0)
    assert bench.steering[-4:] == pytest.approx([before, before, after, after], abs=1e-7)


def test_parameters_in_flight_do_not_disturb_a_tracking_kite():
    """Every parameter set to the value that it has, time and again: not a bit of the flight changes."""
    flights = []
    for disturbed in (False, True):
        bench = Bench(FlyingKite())
        bench.start(dialect.KITE_MODE_TRACK)
        for tick in range(200):
            name = NAMES[tick % len(NAMES)]
            if disturbed and not TABLE[name].disarmed_only and not TABLE[name].read_only:
                bench.tell(set_parameter(name, bench.value(name)))
            bench.step()
        flights.append(bench.steering)
    assert flights[0] == flights[1]
    assert max(abs(steering) for steering in flights[0]) > 0.1
