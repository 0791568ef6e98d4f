"""Hypothesis strategies for the fields of every message of the table, with the extremes of each kind of number."""

import math
import re
import struct

from hypothesis import strategies as st

from protocol import dialect

_SIGNED = {"b": 8, "h": 16, "i": 32, "q": 64}  # bits
_UNSIGNED = {"B": 8, "H": 16, "I": 32, "Q": 64}
_FLOATS = (0.0, -0.0, 1.0, -1.5, math.inf, -math.inf, math.nan, 2.0**-149, -(2.0**-126), 3.4028234663852886e38)


def fields(layout: str) -> list[tuple[int, str]]:
    """(count, code) of each field of a struct format; the count of a plain field is 0."""
    return [(int(count or 0), code) for count, code in re.findall(r"(\d*)([a-zA-Z])", layout)]


def one_value(code: str):
    if code == "f":
        bits = st.integers(0, 2**32 - 1).map(lambda word: struct.unpack("<f", struct.pack("<I", word))[0])
        return st.sampled_from(_FLOATS) | bits
    if code in _SIGNED:
        least, greatest = -(1 << _SIGNED[code] - 1), (1 << _SIGNED[code] - 1) - 1
    else:
        least, greatest = 0, (1 << _UNSIGNED[code]) - 1
    return st.sampled_from((least, 0, greatest)) | st.integers(least, greatest)


def payloads(number: int):
    """Values of message `number`, field by field: a number, bytes, or a list of numbers."""
    strategies = []
    for count, code in fields(dialect.mavlink_map[number].unpacker.format):
        if code == "s":
            strategies.append(st.binary(max_size=count))
        elif count:
            strategies.append(st.lists(one_value(code), min_size=count, max_size=count) | st.just([0] * count))
        else:
            strategies.append(one_value(code))
    return st.tuples(*strategies)
