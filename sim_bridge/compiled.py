"""Functions of numbers and arrays, compiled by numba where it is installed, plain Python where it is not."""

from collections.abc import Callable
from typing import Any, TypeVar

try:
    import numba
except ImportError:
    numba = None

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """`function` as machine code, kept on disk for the next run; both ways give the same numbers to 1e-9.

    NUMBA_DISABLE_JIT=1 in the environment asks for the plain way.
    """
    if numba is None:
        return function
    return numba.njit(cache=True, error_model="numpy")(function)  # type: ignore[return-value]
