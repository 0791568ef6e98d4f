# Runs under MicroPython, started by micropython.py: plays recorded ticks into the firmware and measures.
# Arguments: folder that firmware_py is in, file of datagrams (u16 length, little-endian, then the datagram),
# first tick that counts. Prints one line of JSON.

import gc
import json
import sys
import time

sys.path.insert(0, sys.argv[1])
gc.collect()
before = gc.mem_alloc()
gc.threshold(4096)  # as firmware_py/main.py does: what compiling leaves must not shred the heap

from firmware_py.autopilot import Autopilot  # noqa: E402
from firmware_py.loop import step_lockstep  # noqa: E402
from firmware_py.mavlink.link import MavlinkLink  # noqa: E402

gc.threshold(-1)


class Recorded:
    """A transport that plays a file; what the firmware sends is dropped."""

    datagrams = True

    def __init__(self, name):
        self._file = open(name, "rb")
        self._next = None
        self.tick = False

    def load(self):
        """Get the next datagram ready; False at the end. `tick` says whether it is a KITE_TICK, alone as always."""
        head = self._file.read(2)
        if not head:
            return False
        self._next = self._file.read(head[0] | head[1] << 8)
        self.tick = self._next[7:10] == b"\x51\xc3\x00"
        return True

    def read(self):
        """The datagram, once."""
        data = self._next
        self._next = None
        return data

    def write(self, data):
        """Nobody listens."""


def main(name, first):
    """Play all ticks; those from `first` on are measured."""
    transport = Recorded(name)
    autopilot = Autopilot(MavlinkLink(transport), True)
    gc.collect()
    result = {"import_bytes": gc.mem_alloc() - before, "free_after_import": gc.mem_free()}
    free = []
    tick = total_bytes = total_us = worst_bytes = worst_us = worst_pause = tick_bytes = spent_us = 0
    gc.disable()
    while transport.load():
        start_bytes = gc.mem_alloc()
        start_us = time.ticks_us()
        step_lockstep(autopilot, autopilot.inbox)
        spent_us += time.ticks_diff(time.ticks_us(), start_us)
        tick_bytes += gc.mem_alloc() - start_bytes
        if not transport.tick:
            continue
        if tick >= first:
            total_bytes += tick_bytes
            total_us += spent_us
            worst_bytes = max(worst_bytes, tick_bytes)
            worst_us = max(worst_us, spent_us)
        tick += 1
        tick_bytes = spent_us = 0
        start_us = time.ticks_us()
        gc.collect()
        pause = time.ticks_diff(time.ticks_us(), start_us)
        worst_pause = max(worst_pause, pause if tick > first else 0)
        if tick % 3000 == 0:
            free.append(gc.mem_free())
    count = tick - first
    result.update({
        "word_bytes": 4 if sys.maxsize < 1 << 32 else 8, "ticks": count, "mode": autopilot.modes.mode,
        "bytes_per_tick": total_bytes / count,
        "bytes_per_tick_worst": worst_bytes, "us_per_tick": total_us / count, "us_per_tick_worst": worst_us,
        "collector_pause_worst_us": worst_pause, "free_by_minute": free,
    })
    print(json.dumps(result))


main(sys.argv[2], int(sys.argv[3]))
