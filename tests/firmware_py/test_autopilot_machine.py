"""Random histories of the whole autopilot, held against docs/modes.md tick by tick, in simulated time.

The page is written down as an oracle in documented_modes.py and its neighbours.
"""

import math
from collections import Counter
from typing import Any

import pytest
from documented_commands import Frame
from documented_modes import Documented, Seen
from documented_samples import WRAP
from firmware_bench import (
    ARM,
    DO_SET_MODE,
    MANUAL,
    NAMES,
    PARK,
    STANDBY,
    TRACK,
    FlyingKite,
    command_long,
    set_parameter,
    station_heartbeat,
)
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, precondition, rule, run_state_machine_as_test
from sample_streams import FAULTS, Stream
from simulated_storage import whole_board

from firmware_py.boards.interface import WATCHDOG
from protocol import dialect
from protocol.parameter_table import load_parameters
from protocol.single_precision import float32
from sim_bridge.equipment.sensors import Sample
from sim_bridge.runtimes.tick_output import clock_us

TICKS = Counter[int]()  # by mode, over all histories of a run
COMMANDS = {
    "ARM": (ARM, 1.0, 0.0), "DISARM": (ARM, 0.0, 0.0), "STANDBY": (DO_SET_MODE, 1.0, STANDBY),
    "MANUAL": (DO_SET_MODE, 1.0, MANUAL), "PARK": (DO_SET_MODE, 1.0, PARK), "TRACK": (DO_SET_MODE, 1.0, TRACK)}
FAIL_SAFES: dict[str, tuple[float, ...]] = {
    "STALE_TIME": (0.0625, 0.25, 0.5, 2.0), "RESUME_TRACK": (1.0,), "GCS_LOST_TIME": (2.0, 5.0),
    "MANUAL_TIME": (0.25, 2.0), "PARK_ELEVATION": (0.0, 25.0, 40.0), "STEER_RATE": (0.25, 4.0),
    "STEER_MAX": (0.125, 0.5), "JUMP_RATE": (30.0, 500.0)}
JUMPS_US = (WRAP // 2, WRAP // 2 + 10_000_000, WRAP - 100_000_000)
PREDICTED = {"PRED_DELAY": 0.25, "FF_GAIN": 1.0, "INNER_P": 4.0}
STRANGER = 77
WAIT_TICKS = 150
REFUSALS = 3
GROUND_TICKS = 5

few = st.integers(1, 12)
ticks = st.integers(1, 60)
stations = st.integers(0, 1)
commands = st.sampled_from(sorted(COMMANDS))


class Operator:
    """A ground station: `sent` keeps its last mode commands, as they went out, for copies that come late."""

    def __init__(self, system: int):
        self._mav = dialect.MAVLink(None, system, 190)
        self.sent: list[tuple[bytes, Frame]] = []

    def frame(self, message: dialect.MAVLink_message) -> tuple[bytes, Frame]:
        """The next frame of this station."""
        data = message.pack(self._mav)
        frame = Frame((self._mav.srcSystem, self._mav.srcComponent), self._mav.seq, message)
        self._mav.seq = (self._mav.seq + 1) % 256
        if frame.wish:
            self.sent = [*self.sent[-7:], (data, frame)]
        return data, frame


def any_value(name: str) -> st.SearchStrategy[float]:
    """Values of a parameter: in range, at the edges, a step beyond them, and none at all."""
    entry = load_parameters()[name]
    beyond = (entry.least - 2.0**-10, entry.greatest * 1.001)
    edges = st.sampled_from([entry.least, entry.greatest, entry.default, 0.0, 1e-30, math.nan, math.inf, *beyond])
    if entry.step:
        return edges | st.integers(0, round((entry.greatest - entry.least) / entry.step)).map(
            lambda step: entry.least + step * entry.step)
    return edges | st.floats(entry.least, entry.greatest, width=32)


class AutopilotMachine(RuleBasedStateMachine):
    """The firmware on a board, two ground stations, a kite, and the page as the oracle."""

    @initialize(track=st.integers(0, 5))
    def start(self, track: int) -> None:
        self.board = whole_board()
        self.kite = FlyingKite()
        self.bench = self.board.boot()
        self.documented = Documented()
        self.stream = Stream()
        self.operators = [Operator(255), Operator(7), Operator(STRANGER)]
        self.waiting: list[tuple[bytes, Frame]] = []
        self.told: list[str] = []
        self.pilot_ticks = 0
        self.pilot = 0.0
        self.fly(3)
        if track:
            self.back_to_track()

    # Time goes on

    def fly(self, count: int = 1, late_us: int = 0) -> None:
        """Run ticks, the first late by `late_us`; what waits arrives with it. On the ground a few are enough."""
        for index in range(count if self.documented.armed else min(count, GROUND_TICKS)):
            self.bench.time_s = round(self.bench.time_s + (late_us * 1e-6 if not index else 0.0), 6)
            if self.pilot_ticks:
                self.pilot_ticks -= 1
                if self.pilot_ticks % 5 == 0:
                    self.send(0, dialect.MAVLink_manual_control_message(0, 0, round(self.pilot * 1000), 0, 0, 0))
            self.tick()

    def tick(self) -> None:
        """Run a tick and hold it against the page."""
        bench, documented = self.bench, self.documented
        truth = self.kite(bench.time_s, bench.steering[-1] if bench.steering else 0.0)
        assert truth is not None
        sample = as_sent(self.stream.arriving(truth))
        clock = clock_us(bench.time_s)
        if sample and documented.is_close_call(clock, sample):
            sample = None
        bench.sky = lambda time_s, steering: sample
        arrived, self.waiting = self.waiting, []
        bench._waiting += [data for data, _ in arrived]
        count = len(bench.steering)
        messages = bench.step()
        assert len(bench.steering) == count + 1
        documented.tick(clock, sample, [frame for _, frame in arrived], self.seen(messages))
        self.told = [*self.told[-8:], *bench.texts()]
        bench.heard.clear()
        TICKS[documented.mode] += 1

    def seen(self, messages: list[Any]) -> Seen:
        """What the tick put out."""
        autopilot = self.bench.autopilot
        return Seen(self.bench.steering[-1], messages, autopilot.modes.mode, autopilot.modes.stale,
                    dict(zip(NAMES, autopilot.parameters.values, strict=True)))

    def send(self, station: int, message: dialect.MAVLink_message) -> None:
        """Let a message of a station arrive with the next tick."""
        self.waiting.append(self.operators[station].frame(message))

    def order(self, station: int, wish: str) -> None:
        """Send a mode command, an arm or a disarm."""
        self.send(station, command_long(*COMMANDS[wish], system=0))

    def set(self, station: int, name: str, value: float) -> None:
        """Send a parameter set."""
        self.send(station, set_parameter(name, value))

    def back_to_track(self) -> None:
        """The operator puts all right again: whatever came before, that ends in TRACK."""
        documented = self.documented
        self.stream.disturb("missing", 0)
        if not 0.4 < self.last_elevation < 1.2:
            self.kite = FlyingKite()
        changed = [name for name, entry in load_parameters().items() if documented.parameters[name] != entry.default]
        if any(load_parameters()[name].disarmed_only for name in changed):
            self.order(0, "DISARM")
        for name in changed:
            self.fly()
            self.set(0, name, load_parameters()[name].default)
        self.wait_for("all parameters are at their defaults", lambda: all(
            documented.parameters[name] == load_parameters()[name].default for name in changed))
        self.wait_for("samples are fresh", lambda: not documented.stale)
        self.ask_for("ARM", lambda: documented.armed)
        self.ask_for("TRACK", lambda: documented.mode == TRACK)

    def ask_for(self, wish: str, holds: Any) -> None:
        """Command it until it is so: it is refused where samples go stale meanwhile."""
        for _ in range(REFUSALS):
            self.order(0, wish)
            self.fly()
            self.wait_for(f"an answer to {wish}", lambda: not self.documented.commands.waiting)
            if holds():
                return
            self.wait_for("samples are fresh", lambda: not self.documented.stale)
        raise AssertionError(f"{wish} is refused again and again; told {self.told}, {self.documented.commands.story()}")

    def wait_for(self, what: str, holds: Any) -> None:
        """Fly on until it is so."""
        for _ in range(WAIT_TICKS):
            if holds():
                return
            self.fly()
        story = f"told {self.told}, {self.documented.commands.story()}"
        raise AssertionError(f"not so after {WAIT_TICKS} ticks: {what}; {story}")

    @property
    def last_elevation(self) -> float:
        """Of the kite as it is [rad]."""
        return math.asin(self.kite.plant.truth().position[2])

    # What happens to it

    @rule(count=ticks)
    def nothing_happens(self, count: int) -> None:
        self.fly(count)

    @precondition(lambda self: self.documented.mode != TRACK)
    @rule(count=st.integers(100, 250))
    def the_operator_flies_the_eight(self, count: int) -> None:
        self.back_to_track()
        self.fly(count)

    @rule(name=st.sampled_from(sorted(FAULTS)), duration=st.integers(1, 100), count=ticks)
    def samples_go_wrong(self, name: str, duration: int, count: int) -> None:
        self.stream.disturb(name, duration)
        self.fly(count)

    @rule(station=stations, wish=commands, count=few)
    def a_command(self, station: int, wish: str, count: int) -> None:
        self.order(station, wish)
        self.fly(count)

    @rule(hurry=st.lists(st.tuples(stations, commands, st.integers(0, 3)), min_size=2, max_size=4), count=few)
    def commands_in_a_hurry(self, hurry: list[tuple[int, str, int]], count: int) -> None:
        for station, wish, gap in hurry:
            self.order(station, wish)
            self.fly(gap)
        self.fly(count)

    @rule(station=stations, which=st.integers(1, 4), count=st.integers(0, 12))
    def a_copy_comes_late(self, station: int, which: int, count: int) -> None:
        sent = self.operators[station].sent
        if len(sent) >= which:
            self.waiting.append(sent[-which])
        self.fly(count)

    @rule(sticks=st.integers(-1000, 1000), duration=st.integers(0, 100), count=ticks)
    def the_pilot_steers(self, sticks: int, duration: int, count: int) -> None:
        self.pilot, self.pilot_ticks = sticks / 1000.0, duration
        self.order(0, "MANUAL")
        self.fly(count)

    @rule(station=stations, count=few)
    def a_heartbeat(self, station: int, count: int) -> None:
        self.send(station, station_heartbeat())
        self.fly(count)

    @rule(name=st.sampled_from(sorted(FAIL_SAFES)), choice=st.integers(0, 3), count=ticks)
    def a_fail_safe_is_set(self, name: str, choice: int, count: int) -> None:
        self.set(0, name, FAIL_SAFES[name][choice % len(FAIL_SAFES[name])])
        self.send(0, station_heartbeat())
        self.fly(count)

    @rule(data=st.data(), station=stations, name=st.sampled_from(NAMES), count=few)
    def a_parameter_is_set(self, data: st.DataObject, station: int, name: str, count: int) -> None:
        self.set(station, name, data.draw(any_value(name)))
        self.fly(count)

    @rule(count=ticks)
    def prediction_is_set_up(self, count: int) -> None:
        for name, value in PREDICTED.items():
            self.set(1, name, value)
            self.fly()
        self.fly(count)

    @rule(late_us=st.integers(1, 900_000), count=few)
    def a_tick_is_late(self, late_us: int, count: int) -> None:
        self.fly(count, late_us)

    @rule(jump_us=st.sampled_from(JUMPS_US) | st.integers(0, WRAP - 20_001), count=ticks)
    def the_clock_jumps(self, jump_us: int, count: int) -> None:
        self.fly(count, jump_us)

    @rule(lost=st.integers(0, 100), count=ticks)
    def the_watchdog_bites(self, lost: int, count: int) -> None:
        for _ in range(lost):
            self.kite(0.0, 0.0)
        self.waiting.clear()
        self.documented = self.documented.after_watchdog_reset()
        self.bench = self.board.boot(WATCHDOG)
        self.fly(count)

    @rule(wish=st.sampled_from(["DISARM", "STANDBY", "PARK"]), size=st.integers(1, 60), count=few)
    def a_flood_comes_with_a_command(self, wish: str, size: int, count: int) -> None:
        for _ in range(size):
            self.send(2, dialect.MAVLink_ping_message(1, 2, 0, 0))
        self.order(0, wish)
        self.fly(count)


def as_sent(sample: Sample | None) -> Sample | None:
    """The sample as it comes out of the wire: its numbers are float32."""
    return sample and (sample[0], *map(float32, sample[1:9]), sample[9])  # type: ignore[return-value]


CI = settings(max_examples=60, stateful_step_count=30, derandomize=True, database=None, deadline=None,
              phases=(Phase.generate,),  # shrinking takes minutes: the soak below does it
              suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much])


def test_random_histories_are_those_of_the_page():
    TICKS.clear()
    run_state_machine_as_test(AutopilotMachine, settings=CI)
    assert TICKS[TRACK] >= TICKS.total() / 3, TICKS


@pytest.mark.soak
def test_many_more_random_histories_are_those_of_the_page():
    run_state_machine_as_test(AutopilotMachine, settings=settings(
        CI, max_examples=1000, derandomize=False, print_blob=True, phases=(Phase.generate, Phase.shrink)))
