"""The tlog format: what is written is read back, by us and by pymavlink's own tool."""

import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kite_analysis.flights.tlog import TlogWriter, read_tlog
from protocol import dialect


def frame_of(payload: bytes, marker: int, signed: bool) -> bytes:
    """A frame with the right length around any payload (its checksum is none)."""
    if marker == 0xFE:
        return bytes([marker, len(payload)]) + bytes(4) + payload + bytes(2)
    return bytes([marker, len(payload), signed]) + bytes(7) + payload + bytes(15 if signed else 2)


frames = st.builds(frame_of, st.binary(max_size=255), st.sampled_from([0xFE, 0xFD]), st.booleans())
records = st.lists(st.tuples(st.integers(0, 2**64 - 1), frames), max_size=6)


@pytest.fixture(scope="module")
def path(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("tlog") / "flight.tlog"


def write(path: Path, written: list[tuple[int, bytes]]) -> None:
    with TlogWriter(path) as writer:
        for time_us, frame in written:
            writer.write(time_us, frame)


@given(written=records)
def test_what_is_written_is_read_back(path, written):
    write(path, written)
    assert list(read_tlog(path)) == written


@given(written=records.filter(bool), data=st.data())
def test_a_frame_cut_off_at_the_end_is_left_out(path, written, data):
    write(path, written)
    cut = data.draw(st.integers(1, 8 + len(written[-1][1])))
    path.write_bytes(path.read_bytes()[:-cut])
    assert list(read_tlog(path)) == written[:-1]


@pytest.mark.parametrize("garbage", [b"\x00\x01\x02 no frame", b"\xfd\x01\x80 flags nobody knows"])
def test_garbage_is_named_with_its_place(path, garbage):
    good = frame_of(b"abc", 0xFD, False)
    write(path, [(1, good), (2, garbage)])
    reading = read_tlog(path)
    assert next(reading) == (1, good)
    with pytest.raises(ValueError, match=rf"{path.name}: not a tlog at byte {8 + len(good) + 8}: "):
        next(reading)


def test_pymavlinks_own_tool_reads_it(path):
    encoder = dialect.MAVLink(None, 1, 1)
    beat = dialect.MAVLink_heartbeat_message(
        dialect.MAV_TYPE_KITE, dialect.MAV_AUTOPILOT_GENERIC, 0, dialect.KITE_MODE_PARK, dialect.MAV_STATE_ACTIVE, 3)
    text = dialect.MAVLink_statustext_message(dialect.MAV_SEVERITY_INFO, b"parked")
    write(path, [(1_700_000_000_000_000, beat.pack(encoder)), (1_700_000_001_000_000, text.pack(encoder))])
    tool = Path(sysconfig.get_path("scripts")) / "mavlogdump.py"
    dump = subprocess.run([sys.executable, str(tool), str(path)], capture_output=True, text=True, check=True).stdout
    first, second = dump.splitlines()
    assert "HEARTBEAT" in first and f"custom_mode : {dialect.KITE_MODE_PARK}" in first and first.startswith("2023-11-1")
    assert "STATUSTEXT" in second and "parked" in second
