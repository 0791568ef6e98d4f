"""Bytes over a device file, such as a serial port or a pseudo-terminal, for the PC."""

import select

_MOST = 512


class FileTransport:
    """A stream. The device must be in raw mode; whoever opened it has set its speed."""

    datagrams = False

    def __init__(self, path):
        self._file = open(path, "r+b", 0)  # noqa: SIM115  open as long as the firmware runs
        self._poll = select.poll()
        self._poll.register(self._file, select.POLLIN)

    def read(self):
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

    def write(self, data):
        """Send `data`; what cannot be sent is lost, as on any radio."""
        try:
            self._file.write(data)
        except OSError:
            pass

    def wait(self, timeout_ms):
        """Wait for something to arrive; False if nothing came within `timeout_ms`."""
        return self._readable(timeout_ms)

    def _readable(self, timeout_ms):
        return any(events & select.POLLIN for _, events in self._poll.poll(timeout_ms))
