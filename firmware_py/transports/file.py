"""Bytes over a device file, such as a serial port or a pseudo-terminal, for the PC."""

import select

TYPE_CHECKING = False
if TYPE_CHECKING:
    from io import FileIO
    from typing import Final

    from ..mavlink.interface import Data

_MOST = 512  # type: Final


class FileTransport:
    """A stream. The device must be in raw mode; whoever opened it has set its speed."""

    datagrams = False

    def __init__(self, path: str) -> None:
        self._file: "FileIO" = open(path, "r+b", 0)  # noqa: SIM115  open as long as the firmware runs
        self._poll: "select.poll" = select.poll()
        self._poll.register(self._file, select.POLLIN)

    def read(self) -> bytearray | None:
        """What has arrived, or None. One byte per call: MicroPython's file would wait for more."""
        data = bytearray()
        try:
            while len(data) < _MOST and self._readable(0):
                piece = self._file.read(1)
                if not piece:
                    break
                data += piece
        except OSError:  # unplugged
            pass
        return data or None

    def write(self, data: "Data") -> None:
        """Send `data`; what cannot be sent is lost, as on any radio."""
        try:
            self._file.write(data)
        except OSError:
            pass

    def wait(self, timeout_ms: int) -> bool:
        """Wait for something to arrive; False if nothing came within `timeout_ms`."""
        return self._readable(timeout_ms)

    def _readable(self, timeout_ms: int) -> bool:
        return any(events & select.POLLIN for _, events in self._poll.poll(timeout_ms))
