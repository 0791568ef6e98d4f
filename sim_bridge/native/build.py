"""Builds the compiled loop: `python -m sim_bridge.native.build`, or `make compiled`.

mypyc translates the sources as they are into C, and the C compiler makes a library of it. Floating-point operations
stay as they are written: multiplications and additions are not fused, so that the bits are those of the interpreter.
"""

import ast
import json
import os
import shutil
import sys
import sysconfig
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

from sim_bridge.boards.constants import imported_names
from sim_bridge.native.choice import digest_of
from sim_bridge.native.modules import ABOUT, BUILD, MODULES, ROOT, source_of

WORK = ROOT / "build" / "compiled"  # what is made on the way, and the log
LOG = WORK / "log.txt"
_HEADER = Path(__file__).parent / "primitives.h"
_FLAGS = ["-O3", "-g0", "-ffp-contract=off", "-fno-fast-math", "-include", str(_HEADER)]
_OURS = ("firmware_py", "kite_analysis", "protocol", "sim_bridge")


class BuildError(Exception):
    """The loop could not be compiled; the text says why in one line."""


def build(say: Callable[[str], None]) -> float:
    """Build the loop; return how long it took [s]. What was built before stays in use until the new build is whole.

    Raises:
        BuildError: there is no mypyc, no C compiler, or one of them failed.
    """
    begin = time.monotonic()
    WORK.mkdir(parents=True, exist_ok=True)
    new = WORK / "new"
    shutil.rmtree(new, ignore_errors=True)
    with LOG.open("w", encoding="utf-8") as log:
        with _step("translating", say), _logged(log):
            extensions = _translate()
        with _step("compiling C, which takes a minute or two", say), _logged(log):
            _compile(extensions, new)
    about = {
        "suffix": sysconfig.get_config_var("EXT_SUFFIX"),
        "modules": _files_by_module(new),
        "sources": {file: digest_of(file) for file in sorted(_sources())},
    }
    (new / ABOUT.name).write_text(json.dumps(about, indent=1) + "\n", "utf-8")
    shutil.rmtree(BUILD, ignore_errors=True)
    new.replace(BUILD)
    return time.monotonic() - begin


def _translate() -> list[Any]:
    try:
        from mypyc.build import mypycify  # noqa: PLC0415  an extra

        from sim_bridge.native.primitives import add_primitives  # noqa: PLC0415
    except ImportError as error:
        raise BuildError(f"no mypyc here ({error}): pip install 'kitepilot[compiled]'") from error
    add_primitives()
    options = ["--config-file=", "--follow-imports=silent", "--ignore-missing-imports",
               f"--cache-dir={WORK / 'mypy_cache'}"]
    files = [str(source_of(module).relative_to(ROOT)) for module in MODULES]
    before = Path.cwd()
    os.chdir(ROOT)  # mypyc finds packages from here
    try:
        return mypycify([*options, *files], opt_level="3", target_dir=str(WORK / "c"))
    except SystemExit as error:
        raise BuildError("mypyc refuses a source") from error
    finally:
        os.chdir(before)


def _compile(extensions: list[Any], target: Path) -> None:
    from setuptools import Distribution  # noqa: PLC0415  needed for this alone
    from setuptools.command.build_ext import build_ext  # noqa: PLC0415

    for extension in extensions:
        extension.extra_compile_args = [*extension.extra_compile_args, *_FLAGS]  # they share one list
    command = build_ext(Distribution({"ext_modules": extensions}))
    command.build_lib = str(target)
    command.build_temp = str(WORK / "objects")
    command.ensure_finalized()
    try:
        command.run()
    except Exception as error:  # whatever setuptools, the compiler or the linker come up with
        raise BuildError(f"the C compiler failed: {str(error).splitlines()[0]}") from error


def _files_by_module(folder: Path) -> dict[str, str]:
    """The compiled files by the module's full name; the library that holds the code is a module, too."""
    suffix = str(sysconfig.get_config_var("EXT_SUFFIX"))
    files = (path.relative_to(folder).as_posix() for path in folder.rglob(f"*{suffix}"))
    return {file.removesuffix(suffix).replace("/", "."): file for file in sorted(files)}


def _sources() -> set[str]:
    """All files that the build depends on: the modules, what they import of ours, and the rules for building."""
    found: set[str] = set()
    waiting = [*MODULES, "sim_bridge.native.build", "sim_bridge.native.primitives"]
    while waiting:
        module = waiting.pop()
        source = source_of(module)
        if module.partition(".")[0] not in _OURS or not source.exists():
            continue
        file = source.relative_to(ROOT).as_posix()
        if file not in found:
            found.add(file)
            nodes = ast.walk(ast.parse(source.read_text("utf-8")))
            waiting += imported_names(module, nodes, source.name == "__init__.py")
    return found | {_HEADER.relative_to(ROOT).as_posix()}


@contextmanager
def _logged(log: Any) -> Iterator[None]:
    """Send what is printed meanwhile, by compilers too, into `log`."""
    log.flush()
    kept = [(stream, os.dup(stream)) for stream in (1, 2)]
    try:
        for stream, _ in kept:
            os.dup2(log.fileno(), stream)
        with redirect_stdout(log), redirect_stderr(log):
            yield
    finally:
        log.flush()
        for stream, copy in kept:
            os.dup2(copy, stream)
            os.close(copy)


@contextmanager
def _step(what: str, say: Callable[[str], None]) -> Iterator[None]:
    """Tell what is being done, and now and then that it still is."""
    say(what)
    done = threading.Event()
    begin = time.monotonic()

    def remind() -> None:
        while not done.wait(10.0):
            say(f"  {time.monotonic() - begin:.0f} s")

    thread = threading.Thread(target=remind, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def main() -> int:
    """Build, and say how it went in a line."""
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")  # the terminal, while other output goes into the log

    def say(text: str) -> None:
        print(text, file=out, flush=True)

    try:
        took_s = build(say)
    except (BuildError, OSError) as error:
        say(f"the loop is not compiled: {error}; everything works as before, interpreted (log: {LOG})")
        return 1
    say(f"compiled in {took_s:.0f} s into {BUILD}: kite-sitl uses it from now on (--interpreted: not)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
