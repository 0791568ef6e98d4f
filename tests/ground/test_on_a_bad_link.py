"""The real firmware behind a link that loses a fifth of the frames each way and takes a second there and back.

Time is simulated: `simulated_kite` (conftest.py) gives a transport whose receive() lets the firmware fly on.
"""

import pytest

from ground.errors import NoAnswerError, VehicleError
from ground.session import Session
from protocol import dialect
from protocol.parameter_table import load_parameters
from protocol.single_precision import float32

seeds = pytest.mark.parametrize("seed", range(1, 6))


def session_with(kite) -> Session:
    """A session that has found the vehicle; a warning would be an error here."""
    def refuse(text: str) -> None:
        raise AssertionError(text)

    return kite.session(refuse)


@seeds
def test_the_whole_list_arrives(simulated_kite, seed):
    kite = simulated_kite(seed=seed)
    counts = []
    values = session_with(kite).parameters.fetch_all(lambda count, total: counts.append((count, total)))
    assert list(values) == list(load_parameters())
    assert values == {name: kite.firmware_parameter(name) for name in values}
    assert counts == sorted(counts) and counts[-1] == (len(values), len(values))


@seeds
def test_a_value_is_written_only_as_acknowledged(simulated_kite, seed):
    kite = simulated_kite(seed=seed)
    session = session_with(kite)
    assert session.parameters.set("INNER_P", 2.1) == float32(2.1)
    assert kite.firmware_parameter("INNER_P") == float32(2.1)
    assert session.parameters.fetch("INNER_P") == float32(2.1)


@seeds
def test_refusals_say_why_and_change_nothing(simulated_kite, seed):
    kite = simulated_kite(seed=seed)
    session = session_with(kite)
    before = kite.firmware_parameter("INNER_P")
    with pytest.raises(VehicleError, match=r"^INNER_P: refused by the kite: 99 is outside 0.0625 to 50 1/s$"):
        session.parameters.set("INNER_P", 99.0)
    with pytest.raises(VehicleError, match=r"^INNER_P: refused"):
        session.parameters.set("INNER_P", float("nan"))
    with pytest.raises(VehicleError, match=r"^TABLE_VERSION: .*read-only"):
        session.parameters.set("TABLE_VERSION", 7.0)
    with pytest.raises(VehicleError, match=r"^NO_SUCH_THING: the kite has no such parameter"):
        session.parameters.set("NO_SUCH_THING", 1.0)
    with pytest.raises(VehicleError, match=r"^NO_SUCH_THING: the kite has no such parameter"):
        session.parameters.fetch("NO_SUCH_THING")
    assert session.parameters.fetch("INNER_P") == before == kite.firmware_parameter("INNER_P")


@seeds
def test_a_late_refusal_is_not_taken_for_the_answer_to_the_next_value(simulated_kite, seed):
    kite = simulated_kite(seed=seed)
    session = session_with(kite)
    with pytest.raises(VehicleError, match="outside"):
        session.parameters.set("OUTER_L", 1000.0)
    session.parameters.set("OUTER_L", 7.0)  # while answers to the copies of the first request are still on their way
    assert kite.firmware_parameter("OUTER_L") == 7.0


@seeds
def test_arm_fly_and_disarm(simulated_kite, seed):
    """Settle in STANDBY, arm into PARK, fly TRACK, and meet on the way what is refused where."""
    kite = simulated_kite(seed=seed)
    session = session_with(kite)
    with pytest.raises(VehicleError, match=r"^mode TRACK: refused by the kite: \w+"):
        session.commander.set_mode(dialect.KITE_MODE_TRACK)
    session.commander.arm()
    assert session.state.armed and session.state.mode == dialect.KITE_MODE_PARK
    with pytest.raises(VehicleError, match=r"^LOOP_HZ: .*only while disarmed"):
        session.parameters.set("LOOP_HZ", 100.0)
    session.commander.set_mode(dialect.KITE_MODE_TRACK)
    assert session.state.armed and session.state.mode == dialect.KITE_MODE_TRACK
    session.commander.disarm()
    assert not session.state.armed and session.state.mode == dialect.KITE_MODE_STANDBY
    session.parameters.set("LOOP_HZ", 100.0)
    assert kite.firmware_parameter("LOOP_HZ") == 100.0


@seeds
def test_arming_for_a_curve_that_cannot_be_flown_is_refused_with_the_reason(simulated_kite, seed):
    kite = simulated_kite(seed=seed)
    session = session_with(kite)
    session.parameters.set("EIGHT_ELEVATION", 12.0)  # with EIGHT_HALF_H = 8, below EIGHT_LEAST_EL = 10
    with pytest.raises(VehicleError, match=r"^arm: refused by the kite: (?!.*no reason)\w+"):
        session.commander.arm()
    assert session.state.armed is False


def test_a_dead_link_ends_in_a_clear_error_within_bounded_time(simulated_kite):
    attempts = {
        "INNER_P": lambda session: session.parameters.set("INNER_P", 2.0),
        "OUTER_L": lambda session: session.parameters.fetch("OUTER_L"),
        "parameter list": lambda session: session.parameters.fetch_all(),
        "arm": lambda session: session.commander.arm(),
    }
    for name, attempt in attempts.items():
        kite = simulated_kite(loss=1.0)
        session = Session(kite.links(), print)
        with pytest.raises(NoAnswerError, match=rf"^{name}\b.*: no answer in \d+ s.*: the link is down; check .*try"):
            attempt(session)
        assert 9.0 < kite.clock() < 30.0
        assert kite.firmware_parameter("INNER_P") == load_parameters()["INNER_P"].default


def test_the_link_is_measured(simulated_kite):
    """A minute of telemetry: the round trip is found, and the losses of the way down are counted."""
    session = session_with(simulated_kite(loss=0.2, round_trip_s=1.0))
    assert session.contract.wait(30.0)
    session.connection.wait_until(lambda: False, 60.0)
    connection = session.connection
    assert connection.round_trip.seconds == pytest.approx(1.0, abs=0.1)
    share = connection.statistics.lost / (connection.statistics.lost + connection.statistics.received)
    assert share == pytest.approx(0.2, abs=0.03)
