"""A board's flash and retained memory whose power can be cut, and the firmware on such a board."""

import errno

from firmware_bench import Bench, Sky

from firmware_py.autopilot import Autopilot
from firmware_py.boards.interface import POWER_ON
from firmware_py.boards.retained_layout import SIZE


class PowerCutError(Exception):
    """The power is gone; nothing runs on."""


class SimulatedStorage:
    """Small files, as boards/interface.py has them: a torn write holds its first bytes, a rename is done or not done.

    `log` holds (operation, file) of all that was asked. `full`: no write fits. `worn`: a bit of each write is wrong.
    """

    def __init__(self, files: dict[str, bytes] | None = None):
        self.files = dict(files or {})
        self.log: list[tuple[str, str]] = []
        self.full = False
        self.worn = False
        self._left: int | None = None  # operations that will still be done; None: all
        self._bytes: int | None = None  # of the last one, if it is a write; None: all

    def cut_after(self, operations: int, torn_bytes: int | None = None) -> None:
        """Cut the power after so many more operations; of the last of them, a write, only `torn_bytes` are done."""
        self._left, self._bytes = operations, torn_bytes

    def power_up(self) -> None:
        """The power is back; flash holds what it held."""
        self._left = self._bytes = None

    @property
    def changes(self) -> list[tuple[str, str]]:
        """The operations that change flash."""
        return [entry for entry in self.log if entry[0] != "read"]

    def read(self, name: str) -> bytes | None:
        """See boards/interface.py."""
        self._begin("read", name)
        data = self.files.get(name)
        self._end()
        return data

    def write(self, name: str, data: bytes) -> None:
        """See boards/interface.py."""
        self._begin("write", name)
        if self.full:
            self.files[name] = bytes(data[: len(data) // 2])
            raise OSError(errno.ENOSPC)
        last = self._left == 0
        self.files[name] = bytes(data[: self._bytes] if last and self._bytes is not None else data)
        if self.worn:
            self.files[name] = flipped(self.files[name], len(data) // 2)
        self._end()

    def rename(self, old: str, new: str) -> None:
        """See boards/interface.py."""
        self._begin("rename", old)
        self.files[new] = self.files.pop(old)
        self._end()

    def remove(self, name: str) -> None:
        """See boards/interface.py."""
        self._begin("remove", name)
        del self.files[name]
        self._end()

    def _begin(self, operation: str, name: str) -> None:
        if self._left == 0:
            raise PowerCutError
        if self._left is not None:
            self._left -= 1
        self.log.append((operation, name))

    def _end(self) -> None:
        if self._left == 0:
            raise PowerCutError


class RetainedMemory:
    """Memory that survives a watchdog reset, with noise in it at first. `writes` holds (offset, size) of each."""

    def __init__(self) -> None:
        self.data = bytes(index % 256 for index in range(SIZE))
        self.writes: list[tuple[int, int]] = []

    def read(self, offset: int, size: int) -> bytes:
        """See boards/interface.py."""
        return self.data[offset : offset + size]

    def write(self, offset: int, data: bytes | bytearray) -> None:
        """See boards/interface.py."""
        self.writes.append((offset, len(data)))
        self.data = self.data[:offset] + bytes(data) + self.data[offset + len(data) :]


class Board:
    """What outlives the firmware."""

    def __init__(self, storage: SimulatedStorage | None = None, retained: RetainedMemory | None = None):
        self.storage = storage
        self.retained = retained

    def boot(self, cause: str = POWER_ON, sky: Sky | None = None) -> Bench:
        """Start the firmware anew, its clock at the beginning; the kite in `sky` is where it was."""
        bench = Bench(sky)
        bench.autopilot = Autopilot(bench.autopilot.link, True, self.storage, self.retained, cause)
        bench.runtime.autopilot = bench.autopilot
        return bench


def whole_board() -> Board:
    """A board with everything, fresh from the factory."""
    return Board(SimulatedStorage(), RetainedMemory())


def flipped(data: bytes, position: int, mask: int = 1) -> bytes:
    """`data` with the bits of `mask` flipped in one byte."""
    return data[:position] + bytes([data[position] ^ mask]) + data[position + 1 :]
