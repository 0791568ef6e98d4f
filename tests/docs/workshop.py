"""A copy of the checkout in which the commands of a page are run, with a simulated kite on ports of its own."""

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

from tests.docs.how_they_run import ANSWERS, APPENDED, BEFORE, ENDLESS, PLACEHOLDERS, SHORTER
from tests.docs.markdown_commands import ROOT

_BIN = Path(sys.executable).parent
_PATIENCE_S = 900.0  # for what should have ended long before
_LONG_FLIGHT_S = 125


class Workshop:
    """Runs commands in `folder`, made for it. `real_time`: nothing is shortened or flown faster than it is shown."""

    def __init__(self, folder: Path, real_time: bool):
        if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as in the background of a script: nothing would end
            signal.signal(signal.SIGINT, signal.default_int_handler)
        self._real_time = real_time
        self._port = _free_port()
        self._folder = folder / "checkout"
        self._home = folder / "home"
        self._bin = folder / "bin"
        self._kites: list[subprocess.Popen[str]] = []
        self._copy_checkout()
        self._wrap("kite-ground", f"{_BIN}/kite-ground --link udpin:127.0.0.1:{self._port}")
        self._wrap("make", " ".join([str(shutil.which("make")), *(
            f"-o .venv/.installed{which}" for which in ("", "-dev", "-boards"))]))  # that is: they are up to date

    def run(self, text: str) -> str | None:
        """Run a command; what is wrong with how it went, or None."""
        command = self._command(text)
        process = self._start(command)
        interrupt = threading.Event()
        said = _Said(process, ENDLESS.get(text), interrupt)
        try:
            process.stdin.write(ANSWERS.get(text, ""))  # type: ignore[union-attr]
            process.stdin.close()  # type: ignore[union-attr]
        except BrokenPipeError:
            pass
        if text in ENDLESS:
            interrupt.wait(_PATIENCE_S)
            _interrupt(process)
        try:
            code = process.wait(_PATIENCE_S)
        except subprocess.TimeoutExpired:
            _interrupt(process)
            return f"{command}\nhas no end, or none within {_PATIENCE_S:g} s:\n{said.text()}"
        if code != 0 and not (text in ENDLESS and interrupt.is_set() and code in (130, -signal.SIGINT)):
            return f"{command}\nexit code {code}:\n{said.text()}"
        return f"{command}\n{said.text()}" if "Traceback" in said.text() else None

    def run_python(self, program: str) -> str | None:
        """As `run`, for a program in Python that calls a kite at the usual place."""
        path = self._folder / "shown.py"
        path.write_text(program.replace("udpin:127.0.0.1:14550", f"udpin:127.0.0.1:{self._port}"), "utf-8")
        return self.run("python shown.py")

    def fly(self) -> None:
        """`make sitl`, on ports of this workshop; until `close`."""
        ports = f"--set ground.send_to=127.0.0.1:{self._port} --set ground.listen=127.0.0.1:0"
        self.keep_flying(f"make sitl SPEED={1 if self._real_time else 5} SCENARIO='paper-delay-tuned {ports}'", "TRACK")

    def keep_flying(self, text: str, sign: str) -> None:
        """Start a simulated kite that flies until `close`; wait for `sign` in what it says."""
        process = self._start(self._command(text))
        seen = threading.Event()
        said = _Said(process, sign, seen)
        seen.wait(_PATIENCE_S)
        if process.poll() is not None:
            raise AssertionError(f"{text}\n{said.text()}")
        self._kites.append(process)

    def record_long(self) -> None:
        """A log of two minutes, flown faster than `kite-ground record` could: long.tlog."""
        problem = self.run(f"kite-sitl run paper-delay-tuned --duration {_LONG_FLIGHT_S} --log long "
                           "&& cp long/control.tlog long.tlog")
        if problem:
            raise AssertionError(problem)

    def close(self) -> None:
        """Land."""
        for process in self._kites:
            _interrupt(process)
            process.wait()

    def _copy_checkout(self) -> None:
        ignored = shutil.ignore_patterns(".venv", ".git", "__pycache__", "flights", "build", "*.egg-info", ".*_cache",
                                         ".hypothesis")
        shutil.copytree(ROOT, self._folder, ignore=ignored)
        (self._folder / ".venv").symlink_to(sys.prefix)
        self._home.mkdir()
        self._bin.mkdir()

    def _wrap(self, name: str, command: str) -> None:
        path = self._bin / name
        path.write_text(f'#!/bin/sh\nexec {command} "$@"\n')
        path.chmod(0o755)

    def _command(self, text: str) -> str:
        appended = [APPENDED[text][0]] if text in APPENDED else []
        if text in SHORTER and not self._real_time:
            appended.append(SHORTER[text][0])
        words = re.sub(r"\b(FILE|NAME|KEY)\b", lambda word: PLACEHOLDERS[word[0]], " ".join([text, *appended]))
        import pymavlink  # noqa: PLC0415  for where its dialects are

        dialects = Path(str(pymavlink.__file__)).parent / "dialects" / "v20"
        before = BEFORE.get(text, "true").replace("{dialects}", str(dialects))
        return f"{before} && {words.replace('{port}', str(self._port))}"

    def _start(self, command: str) -> subprocess.Popen[Any]:
        environment = {
            **os.environ, "PATH": f"{self._bin}{os.pathsep}{_BIN}{os.pathsep}{os.environ['PATH']}",
            "HOME": str(self._home), "XDG_STATE_HOME": str(self._home / "state"), "PYTHONUNBUFFERED": "1",
            "MPLCONFIGDIR": _matplotlib_cache(),
        }
        return subprocess.Popen(["bash", "-c", command], cwd=self._folder, env=environment, text=True,
                                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                start_new_session=True)


class _Said:
    """Collects what a process says; sets `seen` when `sign` is in it, or nothing more will come."""

    def __init__(self, process: subprocess.Popen[Any], sign: str | None, seen: threading.Event):
        self._lines: list[str] = []
        self._thread = threading.Thread(target=self._listen, args=(process, sign, seen), daemon=True)
        self._thread.start()

    def _listen(self, process: subprocess.Popen[Any], sign: str | None, seen: threading.Event) -> None:
        for line in process.stdout or ():
            self._lines.append(line)
            if sign and sign in line:
                seen.set()
        seen.set()

    def text(self) -> str:
        """All of it, the process having ended."""
        self._thread.join(5.0)
        return "".join(self._lines)


def _interrupt(process: subprocess.Popen[Any]) -> None:
    """Ctrl-C: to the process and all that it started."""
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGINT)


def _free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as plain:
        plain.bind(("127.0.0.1", 0))
        return plain.getsockname()[1]


def _matplotlib_cache() -> str:
    """Where matplotlib has its list of fonts, which takes long to make."""
    import matplotlib  # noqa: PLC0415

    return matplotlib.get_cachedir()
