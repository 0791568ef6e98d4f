"""What the kite says and answers, at which pace; and that nothing that is said to it disturbs the flight."""

import math

import pytest
from any_message import payloads
from firmware_bench import (
    ARM,
    DO_SET_MODE,
    MANUAL,
    NAMES,
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
    station_heartbeat,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_py.mavlink.generated_messages import KITE_TICK, MESSAGES
from protocol import dialect
from protocol.contract import CONTRACT_HASH

ACCEPTED = dialect.MAV_RESULT_ACCEPTED


def test_timesync_and_ping_are_answered_at_once():
    bench = Bench()
    bench.run(1.0)
    (answer,) = of_kind("TIMESYNC", bench.ask(dialect.MAVLink_timesync_message(0, 987654321012345)))
    assert (answer.tc1, answer.ts1) == (1_000_000_000, 987654321012345)
    assert of_kind("TIMESYNC", bench.ask(dialect.MAVLink_timesync_message(5, 6))) == []  # somebody's answer
    (answer,) = of_kind("PING", bench.ask(dialect.MAVLink_ping_message(77, 5, 0, 0)))
    assert (answer.time_usec, answer.seq, answer.target_system, answer.target_component) == (77, 5, 255, 190)
    for system, component in ((1, 1), (1, 0), (0, 1)):  # somebody's answer
        assert of_kind("PING", bench.ask(dialect.MAVLink_ping_message(77, 5, system, component))) == []


def test_the_version_carries_the_hash_of_the_contract():
    bench = Bench()
    messages = bench.ask(command_long(REQUEST_MESSAGE, 148.0))
    assert [ack.result for ack in of_kind("COMMAND_ACK", messages)] == [ACCEPTED]
    (version,) = of_kind("AUTOPILOT_VERSION", messages)
    assert bytes(version.middleware_custom_version).hex() == CONTRACT_HASH
    assert version.capabilities & dialect.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    assert version.capabilities & dialect.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST


def test_the_list_of_parameters_is_paced_complete_and_may_be_asked_for_again():
    bench = Bench()
    request = dialect.MAVLink_param_request_list_message(1, 1)
    per_tick = [len(of_kind("PARAM_VALUE", bench.ask(request)))]
    while per_tick[-1]:
        per_tick.append(len(of_kind("PARAM_VALUE", bench.step())))
    assert max(per_tick) == 2
    listed = of_kind("PARAM_VALUE", [message for _, message in bench.heard])
    assert [value.param_id for value in listed] == NAMES
    assert [value.param_index for value in listed] == list(range(len(NAMES)))

    bench.heard.clear()
    bench.ask(request)
    bench.run(0.1)
    heard = len(of_kind("PARAM_VALUE", [message for _, message in bench.heard]))
    bench.ask(request)  # a second station: the first one's list goes on, and what the second has missed comes again
    bench.run(1.0)
    listed = of_kind("PARAM_VALUE", [message for _, message in bench.heard])
    assert [value.param_id for value in listed] == NAMES + NAMES[:heard]
    assert of_kind("PARAM_VALUE", bench.ask(dialect.MAVLink_param_request_list_message(2, 1))) == []


def test_heartbeats_come_once_a_second_and_status_with_them():
    bench = Bench()
    bench.run(10.0)
    for kind in ("HEARTBEAT", "SYS_STATUS"):
        times = [time_s for time_s, message in bench.heard if message.get_type() == kind]
        assert times == pytest.approx([float(second) for second in range(10)])
    status = of_kind("SYS_STATUS", [message for _, message in bench.heard])[-1]
    geofence = dialect.MAV_SYS_STATUS_GEOFENCE
    assert status.onboard_control_sensors_health & geofence  # or a ground station warns of a breach


@pytest.mark.parametrize(
    ("rate", "sent"), [(0.0, 0), (0.0625, 1), (0.5, 5), (4.0, 40), (20.0, 200), (50.0, 500), (200.0, 500)])
def test_telemetry_keeps_its_rates(rate, sent):
    bench = Bench()
    bench.set(STATE_HZ=0.0, POSITION_HZ=0.0)
    bench.set(STATE_HZ=rate, POSITION_HZ=min(rate, 50.0))
    bench.heard.clear()
    bench.run(10.0)
    for kind in ("KITE_STATE", "LOCAL_POSITION_NED"):
        assert len(of_kind(kind, [message for _, message in bench.heard])) == pytest.approx(sent, abs=1)


def test_telemetry_comes_back_after_it_was_off_for_long():
    """Off for ten minutes, or no kite to speak of for as long: more than half the clock's wrap."""
    bench = Bench()
    bench.sky = None
    bench.period_s = 0.25
    bench.run(600.0)
    bench.sky = hovering()
    assert len(of_kind("KITE_STATE", bench.run(10.0))) == 40
    bench.set(STATE_HZ=0.0)
    bench.run(600.0)
    bench.set(STATE_HZ=50.0)
    assert len(of_kind("KITE_STATE", bench.run(10.0))) == 40


def test_a_stream_that_is_turned_on_between_the_beats_of_the_others_begins_at_once_and_keeps_its_own():
    bench = Bench()
    bench.set(POSITION_HZ=0.0)
    bench.run(3.3)
    bench.heard.clear()
    bench.set(POSITION_HZ=0.5)
    (set_s,) = [time_s for time_s, message in bench.heard if message.get_type() == "PARAM_VALUE"]
    bench.run(5.0)
    sent = [time_s - set_s for time_s, message in bench.heard if message.get_type() == "LOCAL_POSITION_NED"]
    assert sent == pytest.approx([0.0, 2.0 - PERIOD_S, 4.0 - PERIOD_S])  # it would have been due in the tick before


@pytest.mark.parametrize("jump_s", [-100.0, -2.5, 5.0, 600.0, 1000.0])
def test_a_clock_that_jumps_makes_every_stream_due(jump_s):
    """Between the beats, where nothing but the state is due."""
    bench = Bench()
    bench.run(3.3)
    assert of_kind("SYS_STATUS", bench.step()) == []
    bench.time_s = round(bench.time_s + jump_s, 6)
    messages = bench.step()
    for kind in ("HEARTBEAT", "SYS_STATUS", "NAMED_VALUE_FLOAT", "KITE_STATE", "LOCAL_POSITION_NED"):
        assert len(of_kind(kind, messages)) == 1, kind


def test_the_position_is_sent_in_the_wires_frame():
    """North-east-down there, downwind-left-up here: y and z change sign; the velocity is that of the way flown."""
    bench = Bench(FlyingKite(azimuth=0.3, elevation=0.5, course=-1.0))
    bench.set(POSITION_HZ=50.0)
    bench.run(1.0)
    before, after = of_kind("LOCAL_POSITION_NED", [message for _, message in bench.heard])[-2:]
    assert before.x > 0.0
    assert before.y < 0.0
    assert before.z < 0.0
    assert math.dist((after.x, after.y, after.z), (0.0, 0.0, 0.0)) == pytest.approx(100.0, rel=1e-6)
    for axis in "xyz":
        velocity = (getattr(after, axis) - getattr(before, axis)) / PERIOD_S
        assert getattr(after, f"v{axis}") == pytest.approx(velocity, abs=0.3)
    assert after.time_boot_ms - before.time_boot_ms == 20


def test_a_flood_of_requests_does_not_touch_the_flight():
    """2000 requests in one tick, then 2000 bytes of rubbish each tick: not a bit of the steering changes."""
    flights = []
    for flooded in (False, True):
        bench = Bench(FlyingKite())
        bench.start(TRACK)
        bench.run(1.0)
        if flooded:
            read = dialect.MAVLink_param_request_read_message(1, 1, b"", 3)
            ping = dialect.MAVLink_ping_message(1, 2, 0, 0)
            unknown = command_long(410)
            bench.tell(*(message for _ in range(500) for message in (read, ping, unknown, station_heartbeat())))
        for _ in range(150):
            bench.step()
            assert len(bench.autopilot.inbox.questions.requests) <= 64
            assert len(bench.autopilot.inbox.orders.requests) <= 32
            if flooded:
                bench.tell(*[dialect.MAVLink_ping_message(1, 2, 0, 0)] * 20)
        flights.append(bench.steering)
        if flooded:
            refused = bench.autopilot.inbox.refused
            assert refused > 1900
            status = of_kind("SYS_STATUS", [message for _, message in bench.heard])[-1]
            assert 1900 < status.errors_count4 <= refused
            per_tick = [sum(time_s == at for at, message in bench.heard if message.get_type() == "PING")
                        for time_s in {at for at, _ in bench.heard}]
            assert max(per_tick) <= 8
            bench.run(0.5)
            assert bench.disarm() == ACCEPTED  # once the flood is over, the operator is heard
    assert flights[0] == flights[1][: len(flights[0])]
    assert max(map(abs, flights[0])) > 0.1


@st.composite
def whatever(draw):
    """Any message of the table with anything in its fields, more often than not for this kite."""
    number = draw(st.sampled_from(sorted(set(MESSAGES) - {KITE_TICK})))
    kind = dialect.mavlink_map[number]
    values = dict(zip(kind.ordered_fieldnames, draw(payloads(number)), strict=True))
    for name in ("target_system", "target_component", "target"):
        if name in values:
            values[name] = draw(st.sampled_from([1, 1, 0, values[name]]))
    if "param_id" in values:
        values["param_id"] = draw(st.sampled_from([name.encode() for name in NAMES]) | st.just(values["param_id"]))
    if "command" in values:
        values["command"] = draw(st.sampled_from([ARM, DO_SET_MODE, REQUEST_MESSAGE, values["command"]]))
    return kind(**values)


@settings(deadline=None, max_examples=100)
@given(st.lists(st.lists(whatever(), max_size=4), max_size=12), st.sampled_from([STANDBY, MANUAL, PARK, TRACK]))
def test_no_message_whatever_makes_it_raise_or_steer_beyond_its_limits(ticks, mode):
    """Its own samples go on meanwhile; afterwards it still answers, and still obeys."""
    bench = Bench(FlyingKite())
    if mode != STANDBY:
        bench.start(mode)
    for messages in ticks:
        bench.tell(*messages)
        bench.step()
    bench.run(0.4)
    assert len(bench.steering) >= len(ticks) + 20
    assert all(abs(asked) <= 1.0 for asked in bench.steering)  # also refuses NaN
    system = int(bench.value("SYSTEM_ID"))
    assert bench.ask_for("COMMAND_ACK", command_long(ARM, 0.0, system=system)).result == ACCEPTED
    assert bench.autopilot.modes.mode == STANDBY
