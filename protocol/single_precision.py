"""What is left of a number on the wire, whose fields are of single precision."""

from math import copysign, inf
from struct import Struct
from typing import Final

_PACK: Final = Struct("<f").pack
_UNPACK: Final = Struct("<f").unpack


def float32(value: float) -> float:
    """Round to the nearest float32, as a REAL32 on the wire does. Overflow gives an infinity."""
    try:
        rounded, = _UNPACK(_PACK(value))
    except OverflowError:
        return copysign(inf, value)
    return rounded
