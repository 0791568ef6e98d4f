"""Functions of numbers and arrays, compiled by numba where it is installed, plain Python where it is not."""

import hashlib
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

try:
    import numba
    from numba.core import config
except ImportError:
    numba = config = None

Function = TypeVar("Function", bound=Callable[..., Any])
_HERE = Path(__file__).parent
_FOLDER = "compiled-"


def compiled(function: Function) -> Function:
    """`function` as machine code, kept on disk for the next run; both ways give the same numbers to 1e-9.

    NUMBA_DISABLE_JIT=1 in the environment asks for the plain way.
    """
    if numba is None:
        return function
    return numba.njit(cache=True, error_model="numpy")(function)  # type: ignore[return-value]


def _keep_by_source(settings: Any) -> None:
    """Have numba keep its code in a folder that is named after all sources that may be compiled.

    By itself it looks at the file of a function only, and goes on with old code after a change in what that calls.
    """
    sources = hashlib.sha256()
    for path in sorted((*_HERE.glob("plants/**/*.py"), *_HERE.glob("wind/*.py"), Path(__file__))):
        sources.update(path.read_bytes())
    beside = _HERE / "__pycache__"
    writable = os.access(beside if beside.exists() else _HERE, os.W_OK)
    kept = Path(settings.CACHE_DIR or (beside if writable else Path.home() / ".cache" / "kitepilot"))
    folder = kept / f"{_FOLDER}{sources.hexdigest()[:16]}"
    settings.CACHE_DIR = str(folder)
    for old in kept.glob(f"{_FOLDER}*"):
        if old != folder:
            shutil.rmtree(old, ignore_errors=True)


if numba is not None:
    _keep_by_source(config)
