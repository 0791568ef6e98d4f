"""Writes the ULog format (docs.px4.io, "ULog File Format"), version 1.

A file has a header, definitions (formats, information, parameters), and data: subscriptions, which give a format a
number, and everything with a time. Numbers are little-endian; a message is its size without these three bytes (u16),
its type (u8), and its content.
"""

import struct
from typing import BinaryIO

_MAGIC = b"ULog\x01\x12\x35"
_VERSION = 1
_HEAD = struct.Struct("<HB")
_STAMP = struct.Struct("<Q")
_MOST = 65535


class UlogWriter:
    """Writes to `file`, which the caller closes. `start_us` [us] is on the clock of all later times."""

    def __init__(self, file: BinaryIO, start_us: int) -> None:
        self._file = file
        self._numbers = 0
        file.write(_MAGIC + bytes([_VERSION]) + _STAMP.pack(start_us))
        self._message("B", bytes(40))  # no flags, nothing appended

    def format(self, name: str, fields: list[tuple[str, str]]) -> None:
        """Define a format by the (type, name) of its fields after the time, in order, such as ("float[4]", "q")."""
        text = "".join(f"{kind} {field};" for kind, field in [("uint64_t", "timestamp"), *fields])
        self._message("F", f"{name}:{text}".encode("ascii"))

    def information(self, key: str, value: str | int) -> None:
        """Write a fact about the flight."""
        if isinstance(value, int):
            self._message("I", _keyed(f"uint64_t {key}") + _STAMP.pack(value))
        else:
            text = value.encode("utf-8")
            self._message("I", _keyed(f"char[{len(text)}] {key}") + text)

    def parameter(self, name: str, value: float) -> None:
        """Write a parameter's initial value or, among the data, its new one."""
        self._message("P", _keyed(f"float {name}") + struct.pack("<f", value))

    def subscribe(self, name: str, instance: int) -> int:
        """Subscribe to a format's `instance` (one for each sender), and return the number for its data."""
        number = self._numbers
        self._numbers += 1
        self._message("A", struct.pack("<BH", instance, number) + name.encode("ascii"))
        return number

    def data(self, number: int, time_us: int, content: bytes) -> None:
        """Write one set of values: the fields in order, packed without padding."""
        self._message("D", struct.pack("<H", number) + _STAMP.pack(time_us) + content)

    def text(self, severity: int, time_us: int, text: str) -> None:
        """Write a line of text; `severity` as in the Linux kernel and MAVLink, 0 (worst) to 7."""
        self._message("L", str(severity).encode("ascii") + _STAMP.pack(time_us) + text.encode("utf-8"))

    def _message(self, kind: str, content: bytes) -> None:
        if len(content) > _MOST:
            raise ValueError(f"a ULog message holds {_MOST} bytes, not {len(content)}")
        self._file.write(_HEAD.pack(len(content), ord(kind)) + content)


def _keyed(key: str) -> bytes:
    name = key.encode("ascii", "replace")  # a damaged parameter's name may hold anything
    return bytes([len(name)]) + name
