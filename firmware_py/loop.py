"""Runs the autopilot: in lockstep with a bridge, or in real time on the board's own clock."""

from .generated_messages import KITE_TICK_END
from .ticks import ticks_add, ticks_diff


def run_lockstep(autopilot, transport, silence_ms):
    """Run a tick for each KITE_TICK; return when nothing has come for `silence_ms`."""
    link = autopilot.link
    inbox = autopilot.inbox
    link.send(KITE_TICK_END, (0xFFFFFFFF,))  # says to the bridge where we are
    link.flush()
    while transport.wait(silence_ms):
        step_lockstep(autopilot, inbox)


def step_lockstep(autopilot, inbox):
    """Take in what has arrived; if it brought a tick, run it and end it."""
    link = autopilot.link
    link.receive(inbox)
    if inbox.tick is not None:
        number, time_us = inbox.tick
        inbox.tick = None
        autopilot.tick(time_us)
        link.send(KITE_TICK_END, (number,))
        link.flush()


def run_real_time(autopilot, transport, ticks_us, silence_ms):
    """Run a tick each period of `ticks_us()`; return when nothing has come for `silence_ms`."""
    due = heard = ticks_us()
    while ticks_diff(due, heard) < silence_ms * 1000:
        while True:
            left = ticks_diff(due, ticks_us())
            if left <= 0:
                break
            if transport.wait(left // 1000):
                heard = ticks_us()
                autopilot.link.receive(autopilot.inbox)
        start = ticks_us()
        autopilot.link.receive(autopilot.inbox)
        autopilot.tick(start)
        autopilot.note_tick_time(ticks_diff(ticks_us(), start))
        due = ticks_add(due, autopilot.period_us)
        if ticks_diff(ticks_us(), due) > autopilot.period_us:  # far behind: start the beat anew
            due = ticks_us()
