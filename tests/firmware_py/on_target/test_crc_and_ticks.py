"""CRC and clock, on the interpreter at hand; MicroPython's native CRC must agree with the plain one."""

from firmware_py import clock
from firmware_py.mavlink import crc


def test_check_value_of_mcrf4xx():
    assert crc.crc_bytes(b"123456789", 0, 9, crc.START) == 0x6F91


def test_native_and_plain_agree_on_everything_that_fits_a_frame():
    data = bytearray((index * 37 + index // 7) & 0xFF for index in range(280))
    for start in (0, 1, 9):
        for end in (start, start + 1, 100, 255, 280):
            for seed in (0, 1, 0x8000, 0xFFFF):
                assert crc.crc_bytes(data, start, end, seed) == crc.crc_bytes_plain(data, start, end, seed)


def test_a_byte_more_is_the_same_as_a_longer_run():
    data = b"kite"
    assert crc.crc_byte(data[3], crc.crc_bytes(data, 0, 3, crc.START)) == crc.crc_bytes(data, 0, 4, crc.START)


def test_the_clock_wraps_at_two_to_the_thirty():
    last = (1 << 30) - 1
    assert clock.ticks_add(last, 1) == 0
    assert clock.ticks_diff(5, last) == 6
    assert clock.ticks_diff(last, 5) == -6
    assert clock.ticks_diff(0x1FFFFFFF, 0) == 0x1FFFFFFF
