"""CRC-16/MCRF4XX, the checksum of MAVLink (x^16 + x^12 + x^5 + 1, reflected, start 0xFFFF), and a frame's end."""

from array import array

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Final, TypeAlias

    Bytes: TypeAlias = bytes | bytearray | memoryview

START = 0xFFFF  # type: Final


def _table() -> "array[int]":
    table = array("H", bytes(512))
    for index in range(256):
        value = index
        for _ in range(8):
            value = (value >> 1) ^ 0x8408 if value & 1 else value >> 1
        table[index] = value
    return table


_TABLE = _table()  # type: Final


def crc_bytes_plain(data: "Bytes", start: int, end: int, crc: int) -> int:
    """CRC of `data[start:end]`, continued from `crc`, on any interpreter."""
    table = _TABLE
    for index in range(start, end):
        crc = (crc >> 8) ^ table[(crc ^ data[index]) & 0xFF]
    return crc


def crc_byte(value: int, crc: int) -> int:
    """`crc` continued by one byte."""
    return (crc >> 8) ^ _TABLE[(crc ^ value) & 0xFF]


def seal_plain(buffer: bytearray, start: int, end: int, extra: int) -> int:
    """Finish the MAVLink 2 frame at `start`, whose payload may reach to `end`; return the offset behind it.

    Zero bytes at the payload's end are not sent. Length and CRC are put in; `extra` is the message's CRC extra.
    """
    while end > start + 11 and not buffer[end - 1]:
        end -= 1
    buffer[start + 1] = end - start - 10
    crc = crc_byte(extra, crc_bytes_plain(buffer, start + 1, end, START))
    buffer[end] = crc & 0xFF
    buffer[end + 1] = crc >> 8
    return end + 2


crc_bytes: "Callable[[Bytes, int, int, int], int]" = crc_bytes_plain
seal: "Callable[[bytearray, int, int, int], int]" = seal_plain
try:
    from . import crc_viper

    crc_bytes = crc_viper.crc_bytes
    seal = crc_viper.seal
except (ImportError, SyntaxError, ValueError):  # CPython, no native code here, or .mpy for another processor
    pass
