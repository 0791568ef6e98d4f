"""Runs the autopilot: in lockstep with a bridge, or in real time on a board's own clock."""

from .clock import ticks_add, ticks_diff
from .garbage import Collector
from .mavlink.generated_messages import KITE_SENSORS, KITE_TICK_END
from .parameters.generated_parameters import COLLECT_TICKS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

    from .autopilot import Autopilot
    from .boards.interface import Board, BoardTransport
    from .services.inbox import Inbox

_BOARD = 1  # type: Final  # system and component that a board's own sensors come from


def run_lockstep(autopilot: "Autopilot", transport: "BoardTransport", silence_ms: int) -> None:
    """Run a tick for each KITE_TICK; return when nothing was received for `silence_ms`."""
    link = autopilot.link
    inbox = autopilot.inbox
    link.send(KITE_TICK_END, (0xFFFFFFFF,))  # says to the bridge where we are
    link.flush()
    while transport.wait(silence_ms):
        step_lockstep(autopilot, inbox)


def step_lockstep(autopilot: "Autopilot", inbox: "Inbox") -> None:
    """Receive; if a KITE_TICK has arrived, run and end that tick."""
    link = autopilot.link
    link.lockstep = True
    link.receive(inbox)
    if inbox.tick is not None:
        number, time_us = inbox.tick
        inbox.tick = None
        autopilot.tick(time_us)
        link.send(KITE_TICK_END, (number,))
        link.flush()


def run_real_time(autopilot: "Autopilot", board: "Board") -> None:
    """Run a tick each period of the board's clock, until `board.ended()`.

    Only a completed tick feeds the watchdog: a loop that hangs anywhere resets the board. A tick that
    is more than a period late, because the loop stopped or its clock jumped, counts as an overrun.
    """
    ticks_us = board.ticks_us
    timing = autopilot.timing
    collector = Collector(ticks_us)
    due = ticks_us()
    room = board.bytes_per_tick
    while not board.ended():
        start = _wait(autopilot, board, due, room)
        if not timing.note_start(ticks_diff(start, due), autopilot.period_us):
            due = start
        room = step_real_time(autopilot, board, start, ticks_diff(start, due))
        if autopilot.keeper.wrote:  # to flash, which is done on the ground only: no tick to judge the loop by
            autopilot.keeper.wrote = False
        else:
            timing.note_end(ticks_diff(ticks_us(), start), autopilot.period_us)
        due = ticks_add(due, autopilot.period_us)
        collector.collect_if_due(autopilot.parameters.values[COLLECT_TICKS], ticks_diff(due, ticks_us()))
        if ticks_diff(ticks_us(), due) > autopilot.period_us:  # the tick itself took so long, and is counted
            due = ticks_us()


def _wait(autopilot: "Autopilot", board: "Board", due: int, room: int) -> int:
    """Take in up to `room` bytes until the tick is `due`; return the clock then.

    A time that is further away than a period is none: the clock has jumped, and the tick is due.
    """
    while True:
        now = board.ticks_us()
        left_us = ticks_diff(due, now)
        if left_us <= 0 or left_us > autopilot.period_us:
            return now
        if room > 0 and board.transport.wait(left_us // 1000):
            room -= autopilot.link.receive(autopilot.inbox, room)


def step_real_time(autopilot: "Autopilot", board: "Board", now: int, late_us: int) -> int:
    """One tick of a board, `late_us` after it was due: its sensors in, its actuator out.

    Return how many bytes may be received until the next.
    """
    room = board.bytes_per_tick
    room -= autopilot.link.receive(autopilot.inbox, room)
    if board.sensors is not None:
        autopilot.inbox.sample = None  # a board with sensors of its own believes nobody else's
        sample = board.sensors.sample(now)
        if sample is not None:
            autopilot.inbox.put(KITE_SENSORS, sample, _BOARD, _BOARD)
    autopilot.steer(now, late_us)
    autopilot.link.flush()  # steering waits for nothing
    armed = autopilot.modes.armed()
    if board.actuator is not None:
        board.actuator.write(autopilot.steering.asked, armed)
    autopilot.serve(now)
    if board.actuator is not None and armed != autopilot.modes.armed():
        board.actuator.write(autopilot.steering.asked, not armed)
    board.watchdog.feed()
    board.light.show(autopilot.modes.mode, autopilot.modes.stale, now)
    return room
