"""CRC-16/MCRF4XX, the checksum of MAVLink (x^16 + x^12 + x^5 + 1, reflected, start 0xFFFF)."""

from array import array

START = 0xFFFF


def _table():
    table = array("H", bytes(512))
    for index in range(256):
        value = index
        for _ in range(8):
            value = (value >> 1) ^ 0x8408 if value & 1 else value >> 1
        table[index] = value
    return table


_TABLE = _table()


def crc_bytes_plain(data, start, end, crc):
    """CRC of `data[start:end]`, continued from `crc`, on any interpreter."""
    table = _TABLE
    for index in range(start, end):
        crc = (crc >> 8) ^ table[(crc ^ data[index]) & 0xFF]
    return crc


def crc_byte(value, crc):
    """`crc` continued by one byte."""
    return (crc >> 8) ^ _TABLE[(crc ^ value) & 0xFF]


try:
    from .crc_viper import crc_bytes
except (ImportError, SyntaxError, ValueError):  # CPython, no native code here, or .mpy for another processor
    crc_bytes = crc_bytes_plain
