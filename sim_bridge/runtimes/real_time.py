"""A firmware on its own clock: a tick of the bridge collects messages until the next one is due."""

import time
from collections import deque
from collections.abc import Callable

from protocol import dialect
from sim_bridge.equipment.sensors import Sample
from sim_bridge.errors import FirmwareError
from sim_bridge.links.port import Port
from sim_bridge.runtimes.interface import Message
from sim_bridge.runtimes.interpreter import Interpreter
from sim_bridge.runtimes.process import ProcessRuntime
from sim_bridge.runtimes.tick_output import TickOutput
from sim_bridge.runtimes.wired import WireRuntime

_SETTLE_S = 0.7


class RealTimeRuntime(ProcessRuntime):
    """The process of a ProcessRuntime, on its own clock."""

    pace = "realtime"

    def __init__(self, interpreter: Interpreter | None = None):
        super().__init__(interpreter)
        self._clock = _FlightClock(time.monotonic)

    def begin(self, period_s: float, first_time_s: float) -> None:
        """The clock shows `first_time_s` of the flight now; ticks follow each `period_s`."""
        self._clock.begin(period_s, first_time_s)

    def exchange(self, tick: int, time_s: float, samples: list[Sample], requests: list[Message],
                 datagrams: list[bytes]) -> TickOutput:
        """See Runtime: returns when the next tick is due, with the times at which steering came."""
        self._send_inputs(samples, requests, datagrams)
        output = TickOutput()
        while True:
            self._socket.settimeout(self._clock.left(time_s))
            try:
                data, peer = self._socket.recvfrom(65536)
            except OSError:  # it is time for the next tick
                break
            if peer != self._peer:
                continue
            self._sort(data, self._clock.within(time_s), output)
        self._check_alive("in flight")
        return output


class HilRuntime(WireRuntime):
    """A board behind a port, flown in real time.

    It measures how long the board takes from a sample to the steering that it makes of it, as the KITE_STATE of the
    same tick tells, so that the emulated link can be shortened by that. `clock` is that by which the board lives [s]:
    it goes on while the port waits.
    """

    name = "hil"
    lead_in_s = 6.0  # a slow cable carries some hundred parameters' frames in that time

    def __init__(self, port: Port, patience_s: float = 15.0, clock: Callable[[], float] = time.monotonic):
        super().__init__()
        self._port = port
        self._patience_s = patience_s
        self._now = clock
        self._clock = _FlightClock(clock)
        self._sent_at: dict[int, float] = {}
        self._delays: deque[float] = deque(maxlen=2000)
        self._steering_at = 0.0
        self.bytes_in = 0
        self.bytes_out = 0

    def start(self) -> None:
        """See Runtime: waits for the board's first frame."""
        deadline = self._now() + self._patience_s
        while self._now() < deadline:
            if self._codec.decode(self._port.receive(0.2)):
                self._disarm()  # it may still fly from before
                deadline = self._now() + _SETTLE_S
                while self._now() < deadline:
                    self._port.receive(0.1)  # its answers must not be taken for those to the preflight
                return
        raise FirmwareError(f"no message from the board for {self._patience_s:g} s: is it powered, is this its port, "
                            "is the baud rate right, does its board.py name this link?")

    def begin(self, period_s: float, first_time_s: float) -> None:
        """The clock shows `first_time_s` of the flight now; ticks follow each `period_s`."""
        self._clock.begin(period_s, first_time_s)

    def exchange(self, tick: int, time_s: float, samples: list[Sample], requests: list[Message],
                 datagrams: list[bytes]) -> TickOutput:
        """See Runtime: returns when the next tick is due, with the times at which steering came."""
        for sample in samples:
            sampled_us, *_ = sample
            self._sent_at[sampled_us] = self._now()
        while len(self._sent_at) > 200:
            self._sent_at.pop(next(iter(self._sent_at)))
        self._send_inputs(samples, requests, datagrams)
        output = TickOutput()
        while (left := self._clock.left(time_s)) > 0:
            data = self._port.receive(left)
            self.bytes_in += len(data)
            before = len(output.steering)
            self._sort(data, self._clock.within(time_s), output)
            if len(output.steering) > before:
                self._steering_at = self._now()
            if output.state is not None:
                self._measure(output.state.sample_time_us)
        return output

    def delay(self) -> tuple[float, float] | None:
        """Median and spread (90 % quantile less median) of the board's own delay [s]; None before it is known."""
        if len(self._delays) < 20:
            return None
        ordered = sorted(self._delays)
        median = ordered[len(ordered) // 2]
        return median, ordered[int(0.9 * len(ordered))] - median

    def stop(self) -> None:
        """See Runtime: leaves the board disarmed."""
        self._disarm()
        self._port.close()

    def _disarm(self) -> None:
        for _ in range(3):
            self._port.send(self._codec.encode_message(dialect.MAVLink_command_long_message(
                0, 0, dialect.MAV_CMD_COMPONENT_ARM_DISARM, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)))

    def _measure(self, sample_us: int) -> None:
        sent = self._sent_at.pop(sample_us, None)
        if sent is not None and self._steering_at > sent:
            self._delays.append(self._steering_at - sent)

    def _send(self, datagram: bytes) -> None:
        self.bytes_out += len(datagram)
        self._port.send(datagram)


class _FlightClock:
    """Flight time by `clock` [s]."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._start = clock()
        self._period_s = 0.02

    def begin(self, period_s: float, first_time_s: float) -> None:
        """`first_time_s` is now."""
        self._period_s = period_s
        self._start = self._clock() - first_time_s

    def left(self, tick_time_s: float) -> float:
        """Time [s] until the tick behind the one at `tick_time_s` is due, or 0."""
        return max(0.0, tick_time_s + self._period_s - self._now())

    def within(self, tick_time_s: float) -> float:
        """Flight time, but not beyond the tick that is running."""
        return min(tick_time_s + self._period_s, self._now())

    def _now(self) -> float:
        return self._clock() - self._start
