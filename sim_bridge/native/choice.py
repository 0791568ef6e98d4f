"""Chooses the loop that flies: the compiled build of it, where there is one of these very sources, or the sources.

The choice comes before the first import of a module of the loop. Both fly the same to the last bit.
"""

import hashlib
import importlib.util
import json
import os
import sys
import sysconfig
from importlib.abc import MetaPathFinder
from importlib.machinery import EXTENSION_SUFFIXES, ModuleSpec
from typing import Any

from sim_bridge.native.modules import ABOUT, BUILD, MODULES, ROOT

COMPILED, INTERPRETED = "compiled", "interpreted"
VARIABLE = "KITEPILOT_LOOP"  # in the environment: "interpreted" forces that for all programs


class _Finder(MetaPathFinder):
    """Finds the modules of the loop in the build."""

    def __init__(self, files: dict[str, str]):
        self._files = files

    def find_spec(self, fullname: str, path: Any, target: Any = None) -> ModuleSpec | None:
        """The compiled module of that name, or None."""
        file = self._files.get(fullname)
        return importlib.util.spec_from_file_location(fullname, BUILD / file) if file else None


def choose_loop(interpreted: bool = False) -> str | None:
    """Have the loop's modules imported from the build, unless `interpreted` is asked for, or there is none that fits.

    Returns what to tell the user: why a build that is there is not used, None if there is nothing to tell. Where a
    module of the loop has been imported already, all stays as it is.
    """
    if interpreted or os.environ.get(VARIABLE) == INTERPRETED or not ABOUT.exists():
        return None
    if any(name in sys.modules for name in MODULES):
        return None
    misfit, files = _look_at_build()
    if misfit is not None:
        return f"the compiled loop {misfit}: flying interpreted; `make compiled` builds it anew"
    sys.meta_path.insert(0, _Finder(files))
    return None


def misfit_of_build() -> str | None:
    """Why the build that there is cannot be used here, to go on after "the compiled loop"; None if it can."""
    misfit, _ = _look_at_build()
    return misfit


def _look_at_build() -> tuple[str | None, dict[str, str]]:
    """What is wrong with the build that there is, or None; and its files by module."""
    try:
        about = json.loads(ABOUT.read_text("utf-8"))
        sources, suffix, files = about["sources"], about["suffix"], about["modules"]
    except (OSError, ValueError, KeyError) as error:
        return f"cannot be read ({error!r})", {}
    if suffix != sysconfig.get_config_var("EXT_SUFFIX"):
        return "is for another Python", {}
    for file, digest in sources.items():
        if not (ROOT / file).exists() or digest_of(file) != digest:
            return f"is of other sources ({file} has changed)", {}
    return None, files


def loop_in_use() -> str:
    """COMPILED or INTERPRETED: what the flight's own module was loaded from."""
    module = importlib.import_module("sim_bridge.flight.flight")
    return COMPILED if str(module.__file__).endswith(tuple(EXTENSION_SUFFIXES)) else INTERPRETED


def digest_of(file: str) -> str:
    """Fingerprint of a source file, whose name is relative to the packages' folder."""
    return hashlib.sha256((ROOT / file).read_bytes()).hexdigest()
