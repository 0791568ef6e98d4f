"""Going back: what `param revert` goes back to, and what it does not forget."""

import pytest

from ground.errors import UsageError
from protocol.parameter_table import load_parameters


@pytest.fixture
def snapshots(tmp_path):
    return tmp_path / "state" / "kitepilot"


def test_revert_goes_back_to_how_the_flight_began_however_many_commands_ago(operator, snapshots):
    """Three sets of one gain and one of another, by a command each; revert forgets none of them."""
    operator.is_told(UsageError, "nothing to restore", "param", "revert")
    for value in ("2", "3", "4"):
        assert operator.runs("param", "set", "INNER_P", value) == 0
    assert operator.runs("param", "set", "OUTER_L", "7") == 0
    assert operator.runs("param", "diff", "--to-snapshot") == 0
    assert [line.split()[:3] for line in operator.said.splitlines()[2:]] == [["INNER_P", "4", "1.5"],
                                                                             ["OUTER_L", "7", "5"]]
    assert operator.runs("param", "revert", "outer_l", "--yes") == 0
    assert (operator.kite.firmware_parameter("INNER_P"), operator.kite.firmware_parameter("OUTER_L")) == (4.0, 5.0)
    assert operator.runs("param", "revert", "--yes") == 0
    assert "INNER_P = 1.5, acknowledged by the kite" in operator.said
    assert operator.kite.firmware_parameter("INNER_P") == 1.5
    kept = (snapshots / "system-1.param").read_text().splitlines()
    assert len([line for line in kept if not line.startswith("#")]) == len(load_parameters())


def test_arming_begins_a_flight_and_a_second_arm_does_not(operator):
    assert operator.runs("param", "set", "INNER_P", "2") == 0
    assert operator.runs("arm") == 0
    assert operator.runs("param", "set", "INNER_P", "3") == 0
    assert operator.runs("arm") == 0
    assert operator.runs("param", "revert", "--yes") == 0
    assert operator.kite.firmware_parameter("INNER_P") == 2.0


def test_the_operator_may_say_from_here_on(operator, tmp_path):
    stated = tmp_path / "mine.param"
    assert operator.runs("param", "set", "INNER_P", "2") == 0
    assert operator.runs("param", "snapshot", "--snapshot", stated) == 0
    assert operator.runs("param", "set", "INNER_P", "3") == 0
    assert operator.runs("param", "revert", "--snapshot", stated, "--yes") == 0
    assert operator.kite.firmware_parameter("INNER_P") == 2.0
    assert operator.runs("param", "revert", "--yes") == 0
    assert operator.kite.firmware_parameter("INNER_P") == 1.5


def test_a_vehicle_that_was_started_anew_is_not_taken_back_to_before(operator, snapshots):
    """A board that comes up with other values than before: the old snapshot is put aside, and kept."""
    operator.kite.sleep(60.0)
    assert operator.runs("param", "set", "INNER_P", "2") == 0
    operator.kite.start()
    operator.kite.sleep(5.0)
    operator.is_told(UsageError, "nothing to restore", "param", "revert", "--yes")
    assert operator.runs("param", "set", "OUTER_L", "8") == 0
    assert operator.runs("param", "set", "OUTER_L", "9") == 0
    assert operator.runs("param", "revert", "--yes") == 0
    assert operator.kite.firmware_parameter("OUTER_L") == 5.0
    assert len(list(snapshots.glob("system-1-*.param"))) == 1


def test_another_vehicle_of_the_same_id_is_not_taken_for_this_one(simulated_kite, operator_of):
    """A simulated kite and a real one are often both number 1: their clocks tell them apart."""
    first, second = simulated_kite(loss=0.0), simulated_kite(loss=0.0)
    second.sleep(100.0)
    operator = operator_of(first)
    assert operator.runs("param", "set", "INNER_P", "2") == 0
    second.wall_clock = first.wall_clock
    operator.kite = second
    operator.is_told(UsageError, "nothing to restore", "param", "revert", "--yes")
    assert second.firmware_parameter("INNER_P") == 1.5


def test_a_simulated_kite_that_is_faster_than_the_clock_keeps_its_snapshot(operator):
    operator.kite.speed = 8.0
    for value in ("2", "3"):
        operator.kite.sleep(8.0)
        assert operator.runs("param", "set", "INNER_P", value) == 0
    assert operator.runs("param", "revert", "--yes") == 0
    assert operator.kite.firmware_parameter("INNER_P") == 1.5


def test_a_broken_snapshot_keeps_nobody_from_setting_a_gain(operator, snapshots):
    snapshots.mkdir(parents=True)
    (snapshots / "system-1.param").write_bytes(b"INNER_P so much\n")
    assert operator.runs("param", "set", "INNER_P", "2") == 0
    assert "warning: no snapshot: " in operator.remarked and "'so much'" not in operator.said
    assert operator.kite.firmware_parameter("INNER_P") == 2.0
    operator.is_told(UsageError, "system-1.param:1: .* remove this one", "param", "revert", "--yes")
