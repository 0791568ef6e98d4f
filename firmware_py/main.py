"""The firmware as a process on a PC: `python -m firmware_py.main HOST PORT lockstep|realtime`.

It talks UDP to the bridge at HOST:PORT and ends after ten seconds of its silence.
"""

import sys
import time

from .autopilot import Autopilot
from .loop import run_lockstep, run_real_time
from .mavlink_link import MavlinkLink
from .ticks import MASK
from .udp_transport import UdpTransport

_SILENCE_MS = 10000


def _ticks_us():
    """The clock of the platform, in the firmware's wrap: MicroPython has ticks, CPython nanoseconds."""
    if hasattr(time, "ticks_us"):
        return getattr(time, "ticks_us")() & MASK  # noqa: B009  unknown to CPython's type stubs
    return time.monotonic_ns() // 1000 & MASK


def main(arguments):
    """Run until the bridge falls silent; `arguments` are host, port and pace."""
    host, port, pace = arguments
    transport = UdpTransport(host, int(port))
    autopilot = Autopilot(MavlinkLink(transport), pace == "lockstep")
    if pace == "lockstep":
        run_lockstep(autopilot, transport, _SILENCE_MS)
    else:
        run_real_time(autopilot, transport, _ticks_us, _SILENCE_MS)


if __name__ == "__main__":
    main(sys.argv[1:])
