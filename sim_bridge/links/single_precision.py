"""What is left of a number on the wire, whose fields are of single precision."""

from struct import Struct
from typing import Final

_FIELD: Final = Struct("<f")


def as_single(value: float) -> float:
    """`value` in single precision.

    Raises:
        OverflowError: it is finite and beyond single precision's range.
    """
    single, = _FIELD.unpack(_FIELD.pack(value))
    return single
