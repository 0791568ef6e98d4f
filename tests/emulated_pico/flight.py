"""Flies a simulated kite with an emulated Pico, in the Pico's own time, and says how its ticks kept time."""

from bisect import bisect
from statistics import median
from typing import NamedTuple

from protocol import dialect
from sim_bridge.equipment.sensors import Sample
from sim_bridge.links.wire import BridgeCodec
from sim_bridge.runs.run import RunOptions, RunResult, run_scenario
from sim_bridge.runtimes.interface import Message
from sim_bridge.runtimes.real_time import HilRuntime
from sim_bridge.runtimes.tick_output import TickOutput
from sim_bridge.scenario.scenario import Scenario
from tests.emulated_pico.pico import EmulatedPico, Measured

BAUD = 460800
ON_A_CABLE = {"LINK": "uart", "UART": 0, "UART_TX": 0, "UART_RX": 1, "UART_BAUD": BAUD, "SENSORS": "hil"}  # in board.py
START_S = 20.0  # more than any start takes
_QUANTUM_S = 0.0003  # after a first byte: a frame of steering takes 1 ms at 460800 baud
_PATIENCE_S = 30.0
_BEAT = 50  # ticks, of which one at least begins when it is due


class UartPort:
    """The board's UART as a port (see sim_bridge.links.port): waiting lets the board's time pass."""

    bytes_per_s = BAUD / 10

    def __init__(self, pico: EmulatedPico):
        self._pico = pico

    def send(self, data: bytes) -> None:
        """See Port."""
        self._pico.send(data)

    def receive(self, timeout_s: float) -> bytes:
        """See Port."""
        self._pico.run(max(timeout_s, 1e-6), _QUANTUM_S)
        return self._pico.take_uart()

    def close(self) -> None:
        """See Port: the board flies on."""


class TimeKeeping(NamedTuple):
    """How the board kept time; in ms where not said otherwise."""

    ticks: int
    median: float
    p999: float
    worst: float
    latest: float  # start of a tick after it was due
    lost: int  # ticks that began more than a period late
    collections: int
    in_ticks: int  # collections that fell into a tick
    longest_collection: float
    stack_bytes: int
    clock_mhz: float
    delay: float  # from a sample that is sent to the board to the steering that it makes of it, median

    def __str__(self) -> str:
        return (f"{self.ticks} ticks at {self.clock_mhz:.1f} MHz: median {self.median:.1f}, 99.9 % {self.p999:.1f}, "
                f"worst {self.worst:.1f} ms; latest start {self.latest:.1f} ms, {self.lost} lost; {self.collections} "
                f"collections, {self.in_ticks} in a tick, longest {self.longest_collection:.1f} ms; "
                f"stack {self.stack_bytes} bytes")


class _Watched(HilRuntime):
    """Also notes by the board's clock when each tick of the flight began, as its own messages tell."""

    def __init__(self, pico: EmulatedPico):
        super().__init__(UartPort(pico), _PATIENCE_S, lambda: pico.now)
        self._pico = pico
        self._flies = False
        self._listener = BridgeCodec()
        self._uptime_us = 0
        self._uptimes_us: list[int] = []
        self._clock_less_uptime_us = 0

    def exchange(self, tick: int, time_s: float, samples: list[Sample], requests: list[Message],
                 datagrams: list[bytes]) -> TickOutput:
        """See Runtime."""
        if time_s >= 0.0 and not self._flies:
            self._flies = True
            self._uptimes_us.clear()
            self._pico.measured()
        return super().exchange(tick, time_s, samples, requests, datagrams)

    def _sort(self, data: bytes, time_s: float, output: TickOutput) -> int | None:
        for message in self._listener.decode(data):
            if isinstance(message, dialect.MAVLink_hil_actuator_controls_message):
                self._uptimes_us.append(message.time_usec)
            elif isinstance(message, dialect.MAVLink_kite_state_message) and self._uptimes_us:
                self._clock_less_uptime_us = message.time_us - self._uptimes_us[-1]
        return super()._sort(data, time_s, output)

    def starts_s(self) -> list[float]:
        """When each tick began [s], by the board's clock since its reset."""
        return [(uptime + self._clock_less_uptime_us) * 1e-6 for uptime in self._uptimes_us]


def fly(pico: EmulatedPico, scenario: Scenario) -> tuple[RunResult, TimeKeeping]:
    """Fly `scenario` with a Pico that runs already; time is kept from the start of the flight to its end."""
    runtime = _Watched(pico)
    result = run_scenario(scenario, RunOptions(), runtime=runtime)
    delay_s, _ = runtime.delay() or (0.0, 0.0)
    return result, time_keeping(
        runtime.starts_s(), pico.measured(), 1.0 / scenario.parameter("LOOP_HZ"), delay_s)


def time_keeping(starts: list[float], measured: Measured, period: float, delay_s: float) -> TimeKeeping:
    """From when ticks began [s since the last reset], and what the emulator saw. `period` [s] is the loop's."""
    reset_s = measured.resets[-1][1] if measured.resets else 0.0
    feeds = [feed - reset_s for feed in measured.feeds]
    durations, collections_in_ticks, lost, latest = [], 0, 0, 0.0
    due = min(start - index * period for index, start in enumerate(starts[:_BEAT]))
    collections = [(start - reset_s, took) for start, took in measured.collections]
    for start in starts:
        if start - due > period:
            lost += 1
            due = start
        latest = max(latest, start - due)
        due += period
        at = bisect(feeds, start)
        if at == len(feeds):
            continue
        durations.append(feeds[at] - start)
        collections_in_ticks += sum(start < began < feeds[at] for began, _ in collections)
    ordered = sorted(durations)
    return TimeKeeping(
        len(ordered), 1e3 * median(ordered), 1e3 * ordered[int(0.999 * (len(ordered) - 1))], 1e3 * ordered[-1],
        1e3 * latest, lost, len(collections), collections_in_ticks,
        1e3 * max((took for _, took in collections), default=0.0), measured.stack, 1e-6 * measured.clock_hz,
        1e3 * delay_s)
