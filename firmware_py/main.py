"""The firmware as a process on a PC: `python -m firmware_py.main HOST PORT lockstep|realtime`.

It talks UDP to the bridge at HOST:PORT, or to a device file like a board on a cable, with `serial` for HOST
and the file for PORT. It ends after half a minute of silence.
"""

import gc
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

_IS_MICROPYTHON = sys.implementation.name == "micropython"  # type: Final
if _IS_MICROPYTHON:  # what compiling leaves behind is collected as it goes, or the heap is in pieces afterwards
    getattr(gc, "threshold")(4096)  # noqa: B009  unknown to CPython's type stubs

from .autopilot import Autopilot  # noqa: E402
from .boards.unix_board import UnixBoard  # noqa: E402
from .loop import run_lockstep, run_real_time  # noqa: E402
from .mavlink.link import MavlinkLink  # noqa: E402
from .transports.file import FileTransport  # noqa: E402
from .transports.udp import UdpTransport  # noqa: E402

_SILENCE_MS = 30000  # type: Final


def main(arguments: list[str]) -> None:
    """Run until the bridge falls silent; `arguments` are host, port and pace."""
    host, port, pace = arguments
    if _IS_MICROPYTHON:
        getattr(gc, "threshold")(-1)  # noqa: B009  from here on the loop says when
    transport = FileTransport(port) if host == "serial" else UdpTransport(host, int(port))
    if pace == "lockstep":
        run_lockstep(Autopilot(MavlinkLink(transport), True), transport, _SILENCE_MS)
    else:
        board = UnixBoard(transport, _SILENCE_MS)
        run_real_time(Autopilot(MavlinkLink(board.transport)), board)


if __name__ == "__main__":
    main(sys.argv[1:])
