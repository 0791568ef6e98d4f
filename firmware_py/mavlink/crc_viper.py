"""The loops over bytes of crc.py as native code for MicroPython: ten times as fast. CPython cannot read this file."""

import micropython  # type: ignore[import-not-found]

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, TypeAlias

    ptr8: TypeAlias = Any  # to viper: the bytes of a buffer


@micropython.viper
def crc_bytes(data: ptr8, start: int, end: int, crc: int) -> int:
    """CRC of `data[start:end]`, continued from `crc`."""
    while start < end:
        byte = int(data[start]) ^ (crc & 0xFF)
        byte ^= (byte << 4) & 0xFF
        crc = (crc >> 8) ^ (byte << 8) ^ (byte << 3) ^ (byte >> 4)
        start += 1
    return crc & 0xFFFF


@micropython.viper
def seal(buffer: ptr8, start: int, end: int, extra: int) -> int:
    """See crc.seal_plain."""
    least = start + 11
    while end > least and not int(buffer[end - 1]):
        end -= 1
    buffer[start + 1] = end - start - 10
    crc = 0xFFFF
    at = start + 1
    while at <= end:
        byte = (int(buffer[at]) if at < end else extra) ^ (crc & 0xFF)
        byte ^= (byte << 4) & 0xFF
        crc = (crc >> 8) ^ (byte << 8) ^ (byte << 3) ^ (byte >> 4)
        at += 1
    buffer[end] = crc & 0xFF
    buffer[end + 1] = (crc >> 8) & 0xFF
    return end + 2
