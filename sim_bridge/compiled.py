"""Functions of numbers and arrays, compiled by numba where it is installed, plain Python where it is not.

Importing compiles nothing, and leaves the disk and numba's settings as they are: all that happens at the first call.
"""

import hashlib
import os
import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

try:
    import numba
    from numba.core import caching, config
except ImportError:
    numba = caching = config = None

Function = TypeVar("Function", bound=Callable[..., Any])
_HERE = Path(__file__).parent
_FOLDER = "compiled-"
_SETTINGS: Any = config
_OPTIONS: Any = {"error_model": "numpy", "no_cfunc_wrapper": True}  # nobody calls that wrapper, and it takes time
_NoCache: Any = caching.NullCache if caching else object


def compiled(function: Function) -> Function:
    """`function` as machine code, kept on disk for the next run; both ways give the same numbers to 1e-9.

    NUMBA_DISABLE_JIT=1 in the environment asks for the plain way.
    """
    if numba is None:
        return function
    dispatcher: Any = numba.njit(**_OPTIONS)(function)
    if hasattr(dispatcher, "enable_caching"):
        dispatcher._cache = _CacheAtFirstCompilation(dispatcher)
    return dispatcher


class _CacheAtFirstCompilation(_NoCache):
    """Gives its place to numba's cache on disk when numba first asks for machine code.

    numba itself would make that cache, and its folder, when the function is defined.
    """

    def __init__(self, dispatcher: Any) -> None:
        self._dispatcher = dispatcher

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Called under the compiler's lock, so that no other thread sees the changed setting."""
        asked, _SETTINGS.CACHE_DIR = _SETTINGS.CACHE_DIR, str(_folder(_SETTINGS.CACHE_DIR))
        try:
            self._dispatcher.enable_caching()
        finally:
            _SETTINGS.CACHE_DIR = asked
        return self._dispatcher._cache.load_overload(sig, target_context)


@cache
def _folder(asked: str) -> Path:
    """Where machine code is kept, below `asked` if that is not empty; named after all sources that may be compiled.

    numba itself looks only at the file of a function, and keeps using old code after a change in what that calls.
    Folders of other sources are removed.
    """
    sources = hashlib.sha256()
    for path in sorted((*_HERE.glob("plants/**/*.py"), *_HERE.glob("wind/*.py"), Path(__file__))):
        sources.update(path.read_bytes())
    beside = _HERE / "__pycache__"
    writable = os.access(beside if beside.exists() else _HERE, os.W_OK)
    kept = Path(asked or (beside if writable else Path.home() / ".cache" / "kitepilot"))
    folder = kept / f"{_FOLDER}{sources.hexdigest()[:16]}"
    for old in kept.glob(f"{_FOLDER}*"):
        if old != folder:
            shutil.rmtree(old, ignore_errors=True)
    return folder
