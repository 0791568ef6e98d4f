"""What is left of a number on the wire, whose fields are of single precision."""

from math import copysign, inf
from struct import Struct
from typing import Final

_FIELD: Final = Struct("<f")


def float32(value: float) -> float:
    """Round to the nearest float32, as a REAL32 on the wire does. Overflow gives an infinity."""
    try:
        rounded, = _FIELD.unpack(_FIELD.pack(value))
    except OverflowError:
        return copysign(inf, value)
    return rounded
