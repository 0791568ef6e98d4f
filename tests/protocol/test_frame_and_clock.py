"""A frame's header as pymavlink reads it, and a clock that wraps."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kite_analysis.angles import wrap
from protocol import dialect
from protocol.clock import WRAP_US, RunningClock, ages_s, counted_on, difference_us, nearest_us
from protocol.frame import frame_length, message_id, payload, read_header, with_sequence
from protocol.modes import MODE_NAMES, mode_name

BYTE = st.integers(0, 255)


@given(system=BYTE, component=BYTE, sequence=BYTE, version=st.sampled_from([1, 2]), signed=st.booleans())
def test_a_header_says_what_pymavlink_says(system, component, sequence, version, signed):
    mav = dialect.MAVLink(None, system, component)
    mav.seq = sequence
    if signed and version == 2:
        mav.signing.secret_key, mav.signing.sign_outgoing, mav.signing.timestamp = bytes(32), True, 1
    message = dialect.MAVLink_statustext_message(6, b"hello")
    frame = bytes(message.pack(mav, force_mavlink1=version == 1))
    header = read_header(frame)
    assert header.version == version and header.signed == (signed and version == 2)
    assert header.sender == (system, component) and header.sequence == sequence
    assert header.message == dialect.MAVLINK_MSG_ID_STATUSTEXT and len(frame) == frame_length(frame)
    assert payload(frame, 51) == b"\x06hello".ljust(51, b"\0")
    assert read_header(with_sequence(frame, 255 - sequence)) == header._replace(sequence=255 - sequence)
    if version == 2:
        assert message_id(b"xyz" + frame, 3) == header.message
    for part in (b"", b"x" + frame, frame[:5]):
        with pytest.raises(ValueError):
            read_header(part)


@given(st.lists(st.integers(-2_000_000, 400_000_000), max_size=50), st.integers(0, WRAP_US - 1))
def test_a_clock_is_counted_on_over_wraps_and_over_what_was_overtaken(steps_us, first_us):
    true_us = [sum(steps_us[:count]) for count in range(len(steps_us) + 1)]
    readings = [(first_us + time_us) % WRAP_US for time_us in true_us]
    came_s = [time_us * 1e-6 + 0.1 for time_us in true_us]
    assert counted_on(readings, came_s) == [time_us * 1e-6 for time_us in true_us]


def test_a_board_that_starts_anew_goes_on_by_the_time_that_passed():
    clock = RunningClock()
    assert clock.elapsed_s(300_000_000, 10.0) == 0.0
    assert clock.elapsed_s(301_000_000, 11.0) == 1.0
    assert clock.elapsed_s(500_000, 14.0) == pytest.approx(4.0)
    assert clock.elapsed_s(1_500_000, 15.0) == pytest.approx(5.0)


def test_ages_do_not_jump_where_two_clocks_drift_half_a_turn_apart():
    half_us = WRAP_US // 2
    apart_us = [half_us - 2_000_000 + 1_000_000 * step for step in range(5)]
    assert ages_s([time_us % WRAP_US for time_us in apart_us], [0] * 5) == [time_us * 1e-6 for time_us in apart_us]
    assert difference_us(0, WRAP_US - 5) == 5 and nearest_us(5, 3 * WRAP_US) == 3 * WRAP_US + 5


def test_an_angle_is_wrapped_to_above_minus_pi_and_up_to_pi():
    pi = 3.141592653589793
    assert [wrap(angle) for angle in (pi, -pi, 3 * pi, 0.0)] == [pi, pi, pi, 0.0]
    assert wrap(-3.0) == pytest.approx(-3.0) and wrap(4.0) == pytest.approx(4.0 - 2.0 * pi)


def test_modes_have_the_contracts_names():
    assert list(MODE_NAMES.values()) == ["STANDBY", "MANUAL", "PARK", "TRACK"]
    assert mode_name(dialect.KITE_MODE_PARK) == "PARK" and mode_name(77) == "mode 77"
