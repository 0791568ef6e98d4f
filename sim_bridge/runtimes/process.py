"""The firmware in its own process, in lockstep over UDP."""

import atexit
import importlib.util
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from functools import cache
from pathlib import Path

from sim_bridge.boards.image import PORTABLE, compiled_version, lay_out
from sim_bridge.errors import FirmwareError
from sim_bridge.links.wire import BridgeCodec
from sim_bridge.runtimes.interpreter import Interpreter
from sim_bridge.runtimes.wired import SILENCE_S, WireRuntime

_HEAP = "heapsize=192k"
_HEAP_FROM_SOURCE = "heapsize=256k"  # every name in a source stays on the heap, local ones too
_LOOK_S = 0.2  # how often it is looked whether the process still lives
_MOST_STRAYS = 1000  # datagrams of others that may stand before the answer, when a suspended bridge comes back


@cache
def micropython_and_firmware(interpreter: Interpreter) -> tuple[list[str], Path]:
    """The command that runs MicroPython, and the folder of firmware_py, compiled as for a board, once for this process.

    Native code is left out where the interpreter has none, or of another version than mpy-cross; where it cannot
    read compiled files, or mpy-cross is missing, it runs the sources.
    """
    here = compiled_version()
    if here is None or interpreter.mpy_version is None or interpreter.mpy_version[0] != here[0]:
        return [interpreter.path, "-X", _HEAP_FROM_SOURCE], _sources()
    folder = tempfile.mkdtemp(prefix="kitepilot-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    architecture = interpreter.architecture if interpreter.mpy_version == here else None
    lay_out(Path(folder), {}, architecture or PORTABLE)
    return [interpreter.path, "-X", _HEAP], Path(folder)


def _sources() -> Path:
    spec = importlib.util.find_spec("firmware_py")
    if spec is None or spec.origin is None:
        raise FirmwareError("the package firmware_py is not installed")
    return Path(spec.origin).parent.parent


class ProcessRuntime(WireRuntime):
    """Runtimes `cpython` and, with an `interpreter`, `micropython`; in lockstep."""

    pace = "lockstep"

    def __init__(self, interpreter: Interpreter | None = None):
        super().__init__()
        self.name = "micropython" if interpreter else "cpython"
        self.interpreter = interpreter
        self._command, self._folder = (
            micropython_and_firmware(interpreter) if interpreter else ([sys.executable], _sources()))
        self._process: subprocess.Popen[bytes] | None = None
        self._said = tempfile.TemporaryFile()  # noqa: SIM115  closed by stop()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._peer: tuple[str, int] | None = None

    def start(self) -> None:
        """See Runtime: waits for the first frame of the process, which tells its address."""
        host, port = self._socket.getsockname()
        self._process = subprocess.Popen(
            [*self._command, "-m", "firmware_py.main", host, str(port), self.pace],
            cwd=self._folder, stdin=subprocess.DEVNULL, stdout=self._said, stderr=self._said,
            start_new_session=True)  # (Ctrl-C is for the bridge, which ends the firmware in its time)
        deadline = time.monotonic() + SILENCE_S
        while not self._is_greeting(self._receive(deadline, "when it was started")):
            self._peer = None
            self._check_alive("when it was started")

    def stop(self) -> None:
        """See Runtime."""
        if self._process and self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        self._socket.close()
        self._said.close()

    def _send(self, datagram: bytes) -> None:
        if self._peer:
            self._socket.sendto(datagram, self._peer)

    def _receive(self, deadline: float, when: str) -> bytes:
        strays = 0
        while strays < _MOST_STRAYS:
            self._socket.settimeout(_LOOK_S)
            try:
                data, peer = self._socket.recvfrom(65536)
            except TimeoutError:
                self._check_alive(when)
                if time.monotonic() >= deadline:
                    break
                continue
            if self._peer in (None, peer):
                self._peer = peer
                return data
            strays += time.monotonic() >= deadline  # from a firmware whose bridge had this port before
        raise FirmwareError(f"the firmware is silent {when}: nothing for {SILENCE_S:g} s")

    def _is_greeting(self, data: bytes) -> bool:
        """Is this what the firmware sends first, at its `pace`?"""
        kinds = [message.get_type() for message in BridgeCodec().decode(data)]
        return "KITE_TICK_END" in kinds if self.pace == "lockstep" else bool(kinds)

    def _check_alive(self, when: str) -> None:
        """Raise with the process's last words if it has ended."""
        if self._process and self._process.poll() is not None:
            self._said.seek(0)
            lines = self._said.read().decode(errors="replace").strip().splitlines()
            raise FirmwareError(f"the firmware ended {when}" + (f": {lines[-1]}" if lines else ""))
