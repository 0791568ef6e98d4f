"""Finding messages in bytes: nothing raises, nothing good is lost to something bad, and losses are counted."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.link.framing import FrameReader
from ground.link.round_trip import RoundTrip
from ground.link.statistics import LinkStatistics
from protocol import dialect


def frames(count: int, mavlink_1: bool = False) -> list[bytes]:
    encoder = dialect.MAVLink(None, 1, 1)
    packed = []
    for number in range(count):
        message = dialect.MAVLink_statustext_message(dialect.MAV_SEVERITY_INFO, b"number %d" % number)
        packed.append(message.pack(encoder, force_mavlink1=mavlink_1))
        encoder.seq += 1
    return packed


def texts(reader: FrameReader, data: bytes) -> list[str]:
    return [received.message.text for received in reader.feed(data)
            if isinstance(received.message, dialect.MAVLink_statustext_message)]


@given(st.lists(st.binary(max_size=300), max_size=5))
def test_garbage_never_raises(chunks):
    reader = FrameReader()
    for chunk in chunks:
        list(reader.feed(chunk))


@given(st.sampled_from(sorted(dialect.mavlink_map)), st.binary(max_size=255), st.booleans())
def test_any_payload_with_a_good_checksum_never_raises(number, payload, signed):
    """As a broken or hostile sender could make it: each known message, with arbitrary bytes inside."""
    head = struct.pack("<BBBBBBHB", len(payload), signed, 0, 7, 1, 1, number & 0xFFFF, number >> 16) + payload
    crc = dialect.x25crc(head)
    crc.accumulate(bytes([dialect.mavlink_map[number].crc_extra]))
    frame = b"\xfd" + head + struct.pack("<H", crc.crc) + bytes(13 if signed else 0)
    assert [received.header.sequence for received in FrameReader().feed(frame + frame)] == [7, 7]


@given(st.sampled_from(sorted(dialect.mavlink_map)), st.binary(min_size=255, max_size=255))
def test_every_text_of_every_message_can_be_shown(number, payload):
    """Terminal escapes, line breaks and what turns the text's direction come as replacement characters."""
    head = struct.pack("<BBBBBBHB", len(payload), 0, 0, 7, 1, 1, number & 0xFFFF, number >> 16) + payload
    crc = dialect.x25crc(head)
    crc.accumulate(bytes([dialect.mavlink_map[number].crc_extra]))
    frame = b"\xfd" + head + struct.pack("<H", crc.crc)
    (received,) = FrameReader().feed(frame)
    shown = [value for value in vars(received.message).values() if isinstance(value, str)]
    assert all(text.isprintable() for text in shown) and received.frame == frame


def test_a_status_text_with_escapes_says_the_rest_of_what_it_says():
    message = dialect.MAVLink_statustext_message(dialect.MAV_SEVERITY_INFO, b"\x1b[2Jall is well\nkite 1: PARK\x07")
    assert texts(FrameReader(), message.pack(dialect.MAVLink(None, 1, 1))) == ["�[2Jall is well�kite 1: PARK�"]


@given(st.data())
def test_good_frames_survive_noise_between_them_in_any_chunks(data):
    """Noise that may hold frame starts and lengths; 600 bytes of quiet at the end let every false start run out."""
    noise = st.binary(max_size=40)
    stream = b"".join(data.draw(noise) + frame for frame in frames(5)) + bytes(600)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=6)))
    reader, heard = FrameReader(), []
    for start, end in zip([0, *cuts], [*cuts, len(stream)], strict=True):
        heard += texts(reader, stream[start:end])
    assert heard == [f"number {number}" for number in range(5)]


def test_both_versions_of_the_protocol_and_unknown_messages_are_understood():
    reader = FrameReader()
    assert texts(reader, frames(1, mavlink_1=True)[0]) == ["number 0"]
    unknown = b"\xfd" + bytes([2, 0, 0, 9, 42, 1, 0x39, 0x30, 0]) + b"ab" + b"\x12\x34"
    (received,) = reader.feed(unknown)
    assert isinstance(received.message, dialect.MAVLink_unknown)
    assert (received.header.sender, received.header.sequence, received.frame) == ((42, 1), 9, unknown)


def test_losses_are_counted_by_sequence_number():
    """Ten a second with every fourth missing, over the wrap of the number; then a late one, and a repeated one."""
    statistics = LinkStatistics()
    numbers = [number for number in range(200, 600) if number % 4]
    for number in numbers:
        statistics.add(number / 10.0, number % 256)
    assert (statistics.received, statistics.lost, statistics.repeated) == (300, 99, 0)
    assert statistics.loss(60.0) == pytest.approx(0.25, abs=0.02)
    assert statistics.rate_hz(60.0) == pytest.approx(7.5, abs=0.5)
    statistics.add(60.0, 596 % 256)
    assert statistics.lost == 98
    statistics.add(60.0, 596 % 256)
    assert (statistics.lost, statistics.repeated) == (98, 1)
    assert (statistics.rate_hz(100.0), statistics.loss(100.0)) == (0.0, None)


def test_the_time_out_follows_the_answers():
    round_trip = RoundTrip()
    assert round_trip.timeout_s == 1.0
    for _ in range(50):
        round_trip.add(1.0)
    assert 1.0 < round_trip.timeout_s < 1.5
    for _ in range(50):
        round_trip.add(0.01)
    assert round_trip.timeout_s < 0.5
