"""Writes every frame that comes in to a tlog."""

from pathlib import Path
from types import TracebackType

from analysis.tlog import TlogWriter
from ground.connection import Connection
from ground.errors import UsageError
from ground.framing import Message

_FLUSH_S = 1.0


class Recorder:
    """Records whatever a connection receives, from everyone, to the tlog at `path`, as a context manager.

    `epoch_offset_s` is added to the connection's clock to give seconds since 1970 (UTC).

    Raises:
        UsageError: the file is there already and `overwrite` is not set, or it cannot be made.
    """

    def __init__(self, connection: Connection, path: str | Path, epoch_offset_s: float,
                 overwrite: bool = False) -> None:
        if Path(path).exists() and not overwrite:
            raise UsageError(f"{path}: is there already: give another name, or --force to write over it")
        try:
            self._writer = TlogWriter(path)
        except OSError as error:
            raise UsageError(f"{path}: cannot write: {error.strerror}") from None
        self.frames = 0
        self._epoch_offset_s = epoch_offset_s
        self._flushed_s = connection.clock()
        self._connection = connection
        connection.add_observer(self._observe, everyone=True)

    def _observe(self, time_s: float, message: Message, frame: bytes) -> None:
        self._writer.write(round((time_s + self._epoch_offset_s) * 1e6), frame)
        self.frames += 1
        if time_s - self._flushed_s >= _FLUSH_S:
            self._flushed_s = time_s
            self._writer.flush()

    def __enter__(self) -> "Recorder":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self._connection.remove_observer(self._observe)
        self._writer.close()
