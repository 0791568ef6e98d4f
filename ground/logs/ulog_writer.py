"""Writes the ULog format (docs.px4.io, "ULog File Format"), version 1.

A file is a header, definitions (formats, information, parameters), and then data: subscriptions, which give a format a
number, and everything that has a time. All numbers are little-endian; a message is its size without these three bytes
(u16), its kind (u8), and its content.
"""

import struct
from typing import BinaryIO

_MAGIC = b"ULog\x01\x12\x35"
_VERSION = 1
_HEAD = struct.Struct("<HB")
_STAMP = struct.Struct("<Q")
_MOST = 65535


class UlogWriter:
    """Writes to `file`, which is the caller's. `start_us` is on the clock of all the times that follow [us]."""

    def __init__(self, file: BinaryIO, start_us: int) -> None:
        self._file = file
        self._numbers = 0
        file.write(_MAGIC + bytes([_VERSION]) + _STAMP.pack(start_us))
        self._message("B", bytes(40))  # no flags, nothing appended

    def format(self, name: str, fields: list[tuple[str, str]]) -> None:
        """Define a format by its fields' (type, name) after the time, such as ("float[4]", "q"), in their order."""
        text = "".join(f"{kind} {field};" for kind, field in [("uint64_t", "timestamp"), *fields])
        self._message("F", f"{name}:{text}".encode("ascii"))

    def information(self, key: str, value: str | int) -> None:
        """Tell something about the flight."""
        if isinstance(value, int):
            self._message("I", _keyed(f"uint64_t {key}") + _STAMP.pack(value))
        else:
            text = value.encode("utf-8")
            self._message("I", _keyed(f"char[{len(text)}] {key}") + text)

    def parameter(self, name: str, value: float) -> None:
        """A parameter at the start, or, among the data, its new value from here on."""
        self._message("P", _keyed(f"float {name}") + struct.pack("<f", value))

    def subscribe(self, name: str, instance: int) -> int:
        """The number of the data of this format and instance (the nth that sends it), which it begins."""
        number = self._numbers
        self._numbers += 1
        self._message("A", struct.pack("<BH", instance, number) + name.encode("ascii"))
        return number

    def data(self, number: int, time_us: int, content: bytes) -> None:
        """One set of values: the fields in their order, packed without gaps."""
        self._message("D", struct.pack("<H", number) + _STAMP.pack(time_us) + content)

    def text(self, severity: int, time_us: int, text: str) -> None:
        """A line of text; `severity` as in the Linux kernel and in MAVLink, 0 (worst) to 7."""
        self._message("L", str(severity).encode("ascii") + _STAMP.pack(time_us) + text.encode("utf-8"))

    def _message(self, kind: str, content: bytes) -> None:
        if len(content) > _MOST:
            raise ValueError(f"a ULog message holds {_MOST} bytes, not {len(content)}")
        self._file.write(_HEAD.pack(len(content), ord(kind)) + content)


def _keyed(key: str) -> bytes:
    name = key.encode("ascii", "replace")  # a damaged parameter's name may hold anything
    return bytes([len(name)]) + name
