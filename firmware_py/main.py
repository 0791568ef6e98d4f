"""The firmware as a process on a PC: `python -m firmware_py.main HOST PORT lockstep|realtime`.

It talks UDP to the bridge at HOST:PORT, or to a device file as if it were a board on a cable, with `serial` for HOST
and the file for PORT. It ends after ten seconds of silence.
"""

import sys

from .autopilot import Autopilot
from .board_unix import UnixBoard
from .file_transport import FileTransport
from .loop import run_lockstep, run_real_time
from .mavlink_link import MavlinkLink
from .udp_transport import UdpTransport

_SILENCE_MS = 10000


def main(arguments):
    """Run until the bridge falls silent; `arguments` are host, port and pace."""
    host, port, pace = arguments
    transport = FileTransport(port) if host == "serial" else UdpTransport(host, int(port))
    if pace == "lockstep":
        run_lockstep(Autopilot(MavlinkLink(transport), True), transport, _SILENCE_MS)
    else:
        board = UnixBoard(transport, _SILENCE_MS)
        run_real_time(Autopilot(MavlinkLink(board.transport)), board)


if __name__ == "__main__":
    main(sys.argv[1:])
