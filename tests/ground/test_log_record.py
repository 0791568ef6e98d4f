"""What a recording holds: the flight, all parameters, and the round trips; and how it ends when it must."""

from pathlib import Path

import pytest

from ground.cli.main import main
from ground.errors import GroundError, UsageError
from ground.logs.parameters import LoggedParameters
from ground.logs.quantities import delays, recorded_flight
from ground.logs.reader import read_message_log
from protocol.parameter_table import load_parameters


def test_a_recording_has_the_parameters_and_the_round_trips(operator, tmp_path):
    path = tmp_path / "flight.tlog"
    assert operator.runs("record", path, "--duration", "6") == 0
    assert "messages in 6 s recorded to" in operator.said and "0.0% of the kite's messages were lost" in operator.said
    log = read_message_log(path)
    vehicle = log.vehicle()
    parameters = LoggedParameters(log, vehicle)
    assert parameters.complete
    assert parameters.values(log.duration_s) == {name: entry.default for name, entry in load_parameters().items()}
    round_trips = delays(log, vehicle, recorded_flight(log, vehicle)).round_trip_s
    assert len(round_trips) >= 5
    assert all(0.1 <= seconds <= 0.14 for seconds in round_trips)  # 0.1 s on the way, and up to two ticks


def test_a_gap_in_the_link_is_no_end_of_the_recording(simulated_kite, operator_of, tmp_path):
    """At 40 % loss each way the recording still ends with every parameter."""
    operator = operator_of(simulated_kite(loss=0.4, round_trip_s=0.2))
    assert operator.runs("record", tmp_path / "flight.tlog", "--duration", "40") == 0
    log = read_message_log(tmp_path / "flight.tlog")
    assert LoggedParameters(log, log.vehicle()).complete
    assert 0.35 < float(operator.said.split("(")[1].split("MB), ")[1].split("%")[0]) / 100.0 < 0.45


def test_a_recording_cut_off_anywhere_is_read_up_to_there(operator, tmp_path):
    whole = tmp_path / "whole.tlog"
    operator.runs("record", whole, "--duration", "3")
    frames = [entry.frame for entry in read_message_log(whole).messages]
    data = whole.read_bytes()
    cut = tmp_path / "cut.tlog"
    for length in range(len(data) - 200, len(data)):
        cut.write_bytes(data[:length])
        read = [entry.frame for entry in read_message_log(cut).messages]
        assert read == frames[: len(read)] and len(frames) - len(read) <= 200 // 20


def test_a_full_disk_ends_the_recording_in_one_line(operator, tmp_path):
    full = Path("/dev/full")
    if not full.exists():
        pytest.skip("there is no /dev/full here")
    path = tmp_path / "flight.tlog"
    path.symlink_to(full)
    with pytest.raises(GroundError) as caught:
        operator.runs("record", path, "--force", "--duration", "20")
    assert str(caught.value).startswith(f"{path}: recording stopped after ")
    assert "No space left" in str(caught.value) and "\n" not in str(caught.value)


def test_a_place_that_cannot_be_is_named(operator, tmp_path):
    operator.is_told(UsageError, f"there is no folder {tmp_path / 'none'}", "record", tmp_path / "none" / "f.tlog")
    (tmp_path / "f.tlog").touch()
    operator.is_told(UsageError, "already exists: give another name, or --force", "record", tmp_path / "f.tlog")


@pytest.mark.parametrize(("content", "said"), [
    (None, "cannot read: No such file"), (b"", "holds no message"),
    (b"no flight at all, just text", "not a tlog at byte 8"),
])
@pytest.mark.parametrize("command", ["replay", "log export", "plot"])
def test_what_is_no_log_is_answered_in_one_line(capsys, tmp_path, command, content, said):
    path = tmp_path / "broken.tlog"
    if content is not None:
        path.write_bytes(content)
    assert main([*command.split(), str(path)]) == 2
    output = capsys.readouterr()
    assert f"{path}: {said}" in output.err and output.err.count("\n") == 1 and output.out == ""
