"""Whole tables through bad links, files with mistakes in them, and what is said about each value on the way."""

import re
import statistics

import pytest

from ground.errors import NoAnswerError, UsageError, VehicleError
from ground.parameters.changes import Change, ChangeState
from ground.parameters.file import write_parameter_file
from protocol.parameter_table import load_parameters
from protocol.single_precision import float32


def other_values() -> dict[str, float]:
    """A value for every parameter that is not its default, and that makes a curve that can be flown."""
    chosen = {"EIGHT_ELEVATION": 45.0, "EIGHT_HALF_W": 25.0, "EIGHT_HALF_H": 10.0, "EIGHT_LEAST_EL": 12.0,
              "WINDOW_ANGLE": 80.0, "EIGHT_AZIMUTH": -5.0, "SYSTEM_ID": 7.0}
    values = {}
    for name, entry in load_parameters().items():
        if entry.read_only:
            continue
        step = entry.step or float32((entry.greatest - entry.least) / 64.0)
        if entry.off_at_zero:
            step = entry.least
        away = entry.default + step if entry.default + step <= entry.greatest else entry.default - step
        values[name] = chosen.get(name, float32(away))
    return values


@pytest.mark.parametrize("loss", [0.0, 0.1, 0.3])
@pytest.mark.parametrize("delay_s", [0.1, 0.4, 1.0])
def test_a_whole_table_is_loaded_through_a_bad_link(simulated_kite, operator_of, tmp_path, delay_s, loss):
    """Every settable parameter, the vehicle's own id among them; how often it was asked again is said."""
    kite = simulated_kite(loss=loss, round_trip_s=2.0 * delay_s, seed=4)
    operator, path, values = operator_of(kite), tmp_path / "all.param", other_values()
    write_parameter_file(path, values, ["all of them"])
    assert operator.runs("param", "load", path, "--yes") == 0
    assert {name: kite.firmware_parameter(name) for name in values} == values
    again = re.search(rf"^{len(values)} parameters: {len(values)} acknowledged by the kite; "
                      r"(\d+) retr(?:y|ies)$", operator.said, re.MULTILINE)
    assert again and (int(again[1]) == 0) == (loss == 0.0)
    assert operator.said.count(", acknowledged by the kite\n") == len(values)


def test_a_curve_is_loaded_whose_parameters_must_go_in_another_order(simulated_kite, operator_of, tmp_path):
    """In TRACK the new least elevation alone would forbid the curve: its centre has to go up first."""
    kite = simulated_kite(loss=0.1, round_trip_s=0.2)
    operator, path = operator_of(kite), tmp_path / "higher.param"
    assert operator.runs("arm") == 0 and operator.runs("mode", "track") == 0
    path.write_text("EIGHT_LEAST_EL 38\nEIGHT_ELEVATION 48\n")
    assert operator.runs("param", "load", path, "--yes") == 0
    assert "2 parameters: 2 acknowledged" in operator.said and operator.remarked == ""
    assert [kite.firmware_parameter(name) for name in ("EIGHT_LEAST_EL", "EIGHT_ELEVATION")] == [38.0, 48.0]


def test_what_the_vehicle_refuses_stops_nothing_else(simulated_kite, operator_of, tmp_path):
    kite = simulated_kite(loss=0.1, round_trip_s=0.2)
    operator, path = operator_of(kite), tmp_path / "armed.param"
    assert operator.runs("arm") == 0
    path.write_text("LOOP_HZ 100\nINNER_P 2\n")
    operator.is_told(VehicleError, "^1 of 2 parameters refused: LOOP_HZ$", "param", "load", path, "--yes")
    assert "LOOP_HZ: refused by the kite: it can be set only while disarmed" in operator.remarked
    assert (kite.firmware_parameter("INNER_P"), kite.firmware_parameter("LOOP_HZ")) == (2.0, 50.0)


def test_nothing_of_a_file_with_mistakes_is_sent_unless_the_rest_is_asked_for(operator, tmp_path):
    path = tmp_path / "mistakes.param"
    path.write_text("INNER_P 2.5\nOUTER_L nan\nSTEER_MAX 3\nOUTER_LL 4\nFF_GAIN 1 2 3\nTURN_K 0.5\n")
    operator.is_told(UsageError, "4 lines cannot be sent; nothing was set", "param", "load", path, "--yes")
    assert operator.remarked.splitlines() == [
        f"{path}:2: 'nan' is not a finite number that a float32 holds",
        f"{path}:3: STEER_MAX = 3 is outside 0.0625 to 1",
        f"{path}:4: no parameter is called OUTER_LL; did you mean OUTER_L?",
        f"{path}:5: 'FF_GAIN 1 2 3' is not a parameter: expected NAME value"]
    assert operator.kite.firmware_parameter("INNER_P") == load_parameters()["INNER_P"].default
    assert operator.runs("param", "load", path, "--yes", "--rest") == 0
    assert operator.remarked.count("; skipped") == 4
    assert "2 parameters: 2 acknowledged" in operator.said
    assert [operator.kite.firmware_parameter(name) for name in ("INNER_P", "TURN_K", "OUTER_L", "STEER_MAX")] == [
        2.5, 0.5, 5.0, 1.0]


def test_edited_sent_and_acknowledged_are_told_apart_when_the_link_goes(simulated_kite):
    """The link breaks for good once two values are through: of the others, some were sent and some were not."""
    kite = simulated_kite(loss=0.0, round_trip_s=0.2)
    session = kite.session(print)
    changes = [Change(name, None, value) for name, value in other_values().items() if name != "SYSTEM_ID"]

    def cut(change: Change) -> None:
        if [entry.state for entry in changes].count(ChangeState.ACKNOWLEDGED) == 2:
            kite.radios[0].broken = True

    with pytest.raises(NoAnswerError, match=r"edited, not sent, \d+ sent, not acknowledged, 2 acknowledged by the "
                       r"kite: no answer in \d+ s: the link is down \(link simulated: serial port disconnected\)$"):
        session.parameters.write(changes, cut)
    for change in changes:
        held = kite.firmware_parameter(change.name)
        if change.state is ChangeState.ACKNOWLEDGED:
            assert held == change.wanted
        elif change.state is ChangeState.EDITED:
            assert held == load_parameters()[change.name].default and change.sent == 0


@pytest.mark.parametrize("delay_s", [0.0, 0.1, 0.4])
def test_a_gain_is_acknowledged_within_a_round_trip_and_a_loop_period(simulated_kite, delay_s):
    kite = simulated_kite(loss=0.0, round_trip_s=2.0 * delay_s)
    session = kite.session(print)
    taken_s = []
    for number in range(200):
        sent_s = kite.clock()
        session.parameters.set("INNER_P", 1.0 + number / 128.0)
        taken_s.append(kite.clock() - sent_s)
    assert statistics.median(taken_s) <= 2.0 * delay_s + 0.02 + 1e-9
    assert session.parameters.retries == 0
