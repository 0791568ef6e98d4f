"""The firmware's codec against pymavlink's, in both directions and on every message, then against a hostile link."""

import random
import struct
from typing import Any

import pytest
from any_message import fields, payloads
from hypothesis import example, given, settings
from hypothesis import strategies as st

from firmware_py.mavlink.decoder import Decoder
from firmware_py.mavlink.encoder import LONGEST_FRAME, Encoder
from firmware_py.mavlink.generated_messages import MESSAGES, PARAM_SET, PING, STATUSTEXT
from protocol import dialect

LONGEST_ARRAY = 32  # more numbers than that are bytes to the firmware
UNKNOWN_ID = 230  # ESTIMATOR_STATUS, which a kite does not know
EACH_MESSAGE = pytest.mark.parametrize("number", sorted(MESSAGES), ids=lambda n: dialect.mavlink_map[n].msgname)


def flat(values) -> tuple[Any, ...]:
    """Values as the firmware has them: arrays of numbers spread out."""
    spread = []
    for value in values:
        if isinstance(value, list) and len(value) > LONGEST_ARRAY:
            value = [bytes(value)]  # noqa: PLW2901
        spread += value if isinstance(value, list) else [value]
    return tuple(spread)


def theirs(number: int, values, mav: dialect.MAVLink, mavlink_1: bool = False) -> bytes:
    """The frame that pymavlink makes of `values`."""
    kind = dialect.mavlink_map[number]
    return kind(**dict(zip(kind.ordered_fieldnames, values, strict=True))).pack(mav, force_mavlink1=mavlink_1)


def ours(number: int, values, encoder: Encoder) -> bytes:
    """The frame that the firmware makes of `values`."""
    buffer = bytearray(b"\xaa" * (LONGEST_FRAME + 3))
    end = encoder.encode(buffer, 3, number, flat(values))
    assert buffer[:3] == b"\xaa\xaa\xaa"
    return bytes(buffer[3:end])


def raw_frame(number: int, payload: bytes, sequence: int = 0, sender: int = 1, flags: int = 0) -> bytes:
    """A MAVLink 2 frame around any payload, with a good checksum where the message is known."""
    head = struct.pack("<BBBBBBHB", len(payload), flags, 0, sequence, sender, 1, number & 0xFFFF, number >> 16)
    crc = dialect.x25crc(head + payload)
    crc.accumulate(bytes([MESSAGES[number][1] if number in MESSAGES else 0]))
    return b"\xfd" + head + payload + struct.pack("<H", crc.crc)


def ping(sequence: int, sender: int = 1) -> bytes:
    """A frame that says its own sequence number in its payload, bar the wrap."""
    return raw_frame(PING, struct.pack("<QIBB", 0x0101010101010101, sequence, 1, 1), sequence % 256, sender)


def read(decoder: Decoder, data: bytes, whole: bool = False) -> list[tuple[int, tuple[Any, ...]]]:
    """Feed `data`; return (message, values) of what is found."""
    decoder.feed(data)
    found = []
    while decoder.next_frame(whole):
        found.append((decoder.message, decoder.values))
    return found


def pings(decoder: Decoder, data: bytes, whole: bool = False) -> list[int]:
    """Feed `data`; return the numbers of the pings found."""
    return [values[1] for message, values in read(decoder, data, whole) if message == PING]


def assert_same(number: int, got, values) -> None:
    """Compare by bits: a NaN and a signed zero count."""
    assert struct.pack(MESSAGES[number][0], *got) == struct.pack(MESSAGES[number][0], *flat(values))


@EACH_MESSAGE
@settings(deadline=None, max_examples=60)
@given(data=st.data())
def test_both_codecs_make_the_same_bytes_and_read_them_back(number, data):
    values = data.draw(payloads(number))
    sequence, system, component = data.draw(st.tuples(*[st.integers(0, 255)] * 3))
    mav = dialect.MAVLink(None, system, component)
    encoder = Encoder(system, component)
    mav.seq = encoder.sequence = sequence

    frame = ours(number, values, encoder)
    assert frame == theirs(number, values, mav)
    assert encoder.sequence == (sequence + 1) % 256

    decoder = Decoder()
    ((message, got),) = read(decoder, frame)
    assert (message, decoder.system, decoder.component) == (number, system, component)
    assert_same(number, got, values)
    assert decoder.frames == 1

    heard: Any = dialect.MAVLink(None).decode(bytearray(frame))
    assert (heard.get_seq(), heard.get_srcSystem(), heard.get_srcComponent()) == (sequence, system, component)
    names = zip(heard.ordered_fieldnames, fields(heard.unpacker.format), strict=True)
    their_values = [getattr(heard, f"_{name}_raw" if code == "s" else name) for name, (_, code) in names]
    assert_same(number, flat(their_values), values)


@pytest.mark.parametrize("number", sorted(n for n in MESSAGES if n < 256), ids=lambda n: dialect.mavlink_map[n].msgname)
@settings(deadline=None, max_examples=30)
@given(data=st.data())
def test_mavlink_1_is_read_with_zeros_for_what_it_does_not_have(number, data):
    values = data.draw(payloads(number))
    frame = theirs(number, values, dialect.MAVLink(None, 255, 190), mavlink_1=True)
    length = MESSAGES[number][3]
    old = frame[:1] + bytes([length]) + frame[2 : 6 + length]  # pymavlink sends the extensions too: cut them off
    crc = dialect.x25crc(old[1:])
    crc.accumulate(bytes([MESSAGES[number][1]]))
    full = struct.pack(MESSAGES[number][0], *flat(values))
    for data_1, kept in ((frame, len(full)), (old + struct.pack("<H", crc.crc), length)):
        decoder = Decoder()
        ((message, got),) = read(decoder, data_1)
        assert (message, decoder.system, decoder.component) == (number, 255, 190)
        assert struct.pack(MESSAGES[number][0], *got) == full[:kept] + bytes(len(full) - kept)


@EACH_MESSAGE
def test_payloads_of_any_length_are_read(number):
    """Cut short by a sender (the rest is zeros), not cut although it ends in zeros, or longer in a later version."""
    layout, _, length, _ = MESSAGES[number]
    for size in range(256):
        payload = bytes([7] * min(size, length) + [9] * max(0, size - length))
        ((message, got),) = read(Decoder(), raw_frame(number, payload))
        assert message == number
        assert struct.pack(layout, *got) == (payload + bytes(255))[:length]
    ((_, got),) = read(Decoder(), raw_frame(number, bytes(length)))
    assert struct.pack(layout, *got) == bytes(length)


def test_nothing_of_a_longer_frame_is_left_in_the_next_one():
    decoder = Decoder()
    read(decoder, raw_frame(STATUSTEXT, b"x" * 54))
    assert read(decoder, raw_frame(STATUSTEXT, b"\x04abc")) == [(STATUSTEXT, (4, b"abc" + bytes(47), 0, 0))]


def test_frames_split_at_every_byte_arrive_once_the_last_byte_does():
    unknown = raw_frame(UNKNOWN_ID, bytes(range(42)), 1)
    signed = raw_frame(PING, bytes([1] * 14), 2, flags=1) + b"\x55" * 13
    old = theirs(PING, (1, 1, 1, 1), dialect.MAVLink(None, 9, 9), mavlink_1=True)
    for frame, found in ((ping(1), 1), (unknown, 0), (signed, 1), (old, 1)):
        stream = ping(0) + frame + ping(2)
        for cut in range(len(stream) + 1):
            decoder = Decoder()
            first = read(decoder, stream[:cut])
            whole_frames = (cut >= len(ping(0))) + found * (cut >= len(ping(0) + frame)) + (cut == len(stream))
            assert len(first) == whole_frames
            assert len(first + read(decoder, stream[cut:])) == 2 + found
            assert (decoder.bad_crc, decoder.unknown) == (0, 1 - found)


def test_a_byte_at_a_time():
    decoder = Decoder()
    stream = b"".join(ping(number) for number in range(600))
    assert [n for byte in stream for n in pings(decoder, bytes([byte]))] == list(range(600))
    assert (decoder.frames, decoder.lost, decoder.overflowed) == (600, 0, 0)


# Noise as it comes: bytes, pieces of frames, frames with a bit turned over.
noise = st.one_of(
    st.binary(max_size=60),
    st.builds(lambda frame, start, end: frame[start:end], st.sampled_from([ping(3), raw_frame(PARAM_SET, b"7" * 23)]),
              st.integers(0, 10), st.integers(5, 30)),
    st.builds(lambda at, bit: bytes(b ^ (bit if i == at else 0) for i, b in enumerate(ping(4))),
              st.integers(1, len(ping(4)) - 1), st.sampled_from([1, 2, 4, 8, 16, 32, 64, 128])),
)


@settings(deadline=None, max_examples=300)
@given(noise)
@example(b"\xfe2\x00\x00\x00\x02")
def test_in_datagrams_a_good_frame_behind_noise_is_found_at_once(garbage):
    """Two behind it, as noise that looks just like a frame of an unknown message may hide the first.

    It hides both where it claims to end with the datagram, as a good frame does; then it does not with a third.
    """
    decoder = Decoder()
    found = pings(decoder, garbage + ping(100) + ping(101), whole=True)
    if not found:
        assert decoder.unknown
        assert pings(Decoder(), garbage + ping(100) + ping(101) + ping(102), whole=True) == [102]
        return
    assert found[-1] == 101
    if not decoder.unknown:
        assert found[-2:] == [100, 101]
    assert pings(decoder, ping(102), whole=True) == [102]  # and nothing of it is left for the next datagram


@settings(deadline=None, max_examples=300)
@given(noise, st.integers(1, 40))
def test_in_a_stream_a_good_frame_behind_noise_is_found_when_enough_has_come(garbage, size):
    """Noise that begins like a long frame makes the decoder wait for its end: 280 bytes at the most."""
    decoder = Decoder()
    stream = garbage + b"".join(ping(number) for number in range(100, 120))
    found = [n for at in range(0, len(stream), size) for n in pings(decoder, stream[at : at + size])]
    assert found == sorted(found)
    assert set(found) >= set(range(112, 120))
    if not decoder.unknown:
        assert found[-20:] == list(range(100, 120))


@pytest.mark.parametrize("whole", [True, False])
def test_a_frame_inside_an_unknown_one_is_not_taken_out_of_it(whole):
    """A file transfer may well carry a log of this very link."""
    carrier = raw_frame(UNKNOWN_ID, b"log:" + ping(50) + b"end", 0)
    decoder = Decoder()
    for cut in range(len(carrier)) if not whole else [0]:
        assert pings(decoder, carrier[:cut], whole) == []
        assert pings(decoder, carrier[cut:] + ping(1), whole) == [1]
    assert decoder.unknown == (1 if whole else len(carrier))


def test_bad_checksums_are_counted_and_cost_only_their_own_frame():
    decoder = Decoder()
    for at in range(10, len(ping(0))):  # any byte of payload or checksum
        broken = bytearray(ping(1))
        broken[at] ^= 0x04
        assert pings(decoder, ping(0) + bytes(broken) + ping(2)) == [0, 2]
    assert decoder.bad_crc == len(ping(0)) - 10


def test_a_header_with_an_unknown_feature_is_stepped_over():
    decoder = Decoder()
    strange = raw_frame(PING, bytes([1] * 14), 1, flags=0x80)
    assert pings(decoder, ping(0) + strange + ping(2)) == [0, 2]
    assert (decoder.unknown, decoder.bad_crc, decoder.lost) == (1, 0, 0)


def test_lost_frames_are_counted_by_sender_and_over_the_wrap():
    decoder = Decoder()
    for number in (250, 251, 254, 255, 0, 3):  # 252, 253, 1 and 2 are missing
        read(decoder, ping(number))
    assert decoder.lost == 4
    for number in (77, 78, 80):  # another sender, of which 79 is missing
        read(decoder, ping(number, sender=2))
    assert decoder.lost == 5
    read(decoder, ping(4))
    assert decoder.lost == 5


def test_unknown_messages_copies_and_late_frames_are_not_lost_ones():
    decoder = Decoder()
    for frame in (ping(0), raw_frame(UNKNOWN_ID, bytes([1] * 40), 1), ping(2), ping(2), ping(3), ping(1), ping(4)):
        read(decoder, frame, whole=True)
    assert (decoder.unknown, decoder.lost) == (1, 0)
    for sender in range(20):  # more senders than are followed
        read(decoder, ping(9, sender), whole=True)
    assert decoder.frames == 6 + 20


def test_signed_frames_are_read_and_their_signature_stepped_over():
    mav = dialect.MAVLink(None, 1, 1)
    mav.signing.secret_key = bytes(range(32))
    mav.signing.sign_outgoing = True
    mav.signing.timestamp = 0xFDFEFD  # markers inside the signature
    stream = b""
    for number in range(50):
        mav.seq = number
        stream += theirs(PING, (0, number, 0, 0), mav)
    assert stream[2] == 1
    assert len(theirs(PING, (0, 1, 0, 0), mav)) == 12 + 9 + 13
    for whole in (True, False):
        decoder = Decoder()
        assert pings(decoder, stream + ping(50), whole) == list(range(51))
        assert (decoder.bad_crc, decoder.unknown, decoder.lost) == (0, 0, 0)


def test_the_longest_frame_there_can_be_fits():
    longest = raw_frame(PING, bytes([5] * 255), flags=1) + bytes(13)
    assert len(longest) == LONGEST_FRAME
    assert len(read(Decoder(LONGEST_FRAME), longest)) == 1


def test_what_does_not_fit_is_counted_and_the_link_goes_on():
    decoder = Decoder(100)
    start = ping(0)[:10]
    assert read(decoder, start) == []
    decoder.feed(bytes(95))
    assert decoder.overflowed == 5
    assert not decoder.next_frame()
    assert pings(decoder, ping(1)) == [1]
    decoder.feed(memoryview(ping(2) * 10))
    assert decoder.overflowed == 5 + 10 * len(ping(2)) - 100
    assert decoder.next_frame()


@pytest.mark.parametrize("whole", [True, False])
def test_a_million_bytes_of_noise_raise_nothing(whole):
    """Half of it random, half frames with a few bits turned over; every so often the link falls quiet, then is good."""
    dice = random.Random(1)
    decoder = Decoder()
    good = [raw_frame(number, bytes(dice.randrange(256) for _ in range(MESSAGES[number][2]))) for number in MESSAGES]
    fed = heard = rounds = 0
    while fed < 1_000_000:
        if dice.random() < 0.5:
            chunk = dice.randbytes(dice.randrange(1, 1400))
        else:
            mutated = bytearray(b"".join(dice.choices(good, k=20)))
            for _ in range(dice.randrange(1, 30)):
                mutated[dice.randrange(len(mutated))] ^= 1 << dice.randrange(8)
            chunk = bytes(mutated)[dice.randrange(50) : 1400]
        read(decoder, chunk, whole)
        fed += len(chunk)
        if dice.random() < 0.1:
            rounds += 1
            read(decoder, b"" if whole else bytes(600), whole)
            heard += pings(decoder, ping(rounds % 200), whole) == [rounds % 200]
    assert rounds > 50
    assert heard == rounds
    assert decoder.bad_crc > 1000
    assert decoder.unknown > 0
    assert decoder.overflowed == 0
