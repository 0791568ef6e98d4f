"""Writes every frame that comes in to a tlog."""

from pathlib import Path
from types import TracebackType

from ground.errors import GroundError, UsageError
from ground.link.connection import GROUND_COMPONENT, GROUND_SYSTEM, Connection
from ground.link.framing import Message
from kite_analysis.flights.tlog import TlogWriter
from protocol import dialect

_FLUSH_S = 1.0


class RecordingError(GroundError):
    """The file cannot be written any further; what came before is in it."""


class Recorder:
    """Records whatever a connection receives, from everyone, to the tlog at `path`, as a context manager.

    `epoch_offset_s` is added to the connection's clock to give seconds since 1970 (UTC). The first frame is a TIMESYNC
    of this ground station, which tells its own clock: by it a reader finds the round trips from the answers that
    follow. What comes in is handed to the operating system once a second, so that no more is lost when this program
    is killed.

    Raises:
        UsageError: the file is there already and `overwrite` is not set, or it cannot be made.
        RecordingError: from within the connection's `poll`, when the file can no longer be written.
    """

    def __init__(self, connection: Connection, path: str | Path, epoch_offset_s: float,
                 overwrite: bool = False) -> None:
        path = Path(path)
        if path.exists() and not overwrite:
            raise UsageError(f"{path}: already exists: give another name, or --force to overwrite it")
        if not path.parent.is_dir():
            raise UsageError(f"{path}: there is no folder {path.parent}")
        try:
            self._writer = TlogWriter(path)
        except OSError as error:
            raise UsageError(f"{path}: cannot write: {error.strerror}") from None
        self.path = path
        self.frames = 0
        self.bytes = 0
        self.started_s = self._flushed_s = connection.clock()
        self._epoch_offset_s = epoch_offset_s
        self._connection = connection
        clock = dialect.MAVLink_timesync_message(0, int(self.started_s * 1e9))
        self._write(self.started_s, clock.pack(dialect.MAVLink(None, GROUND_SYSTEM, GROUND_COMPONENT)))
        connection.add_observer(self._observe, everyone=True)

    @property
    def elapsed_s(self) -> float:
        """How long it has been recording [s]."""
        return self._connection.clock() - self.started_s

    def _observe(self, time_s: float, message: Message, frame: bytes) -> None:
        self._write(time_s, frame)
        self.frames += 1

    def _write(self, time_s: float, frame: bytes) -> None:
        try:
            self._writer.write(round((time_s + self._epoch_offset_s) * 1e6), frame)
            self.bytes += 8 + len(frame)
            if time_s - self._flushed_s >= _FLUSH_S:
                self._flushed_s = time_s
                self._writer.flush()
        except OSError as error:
            raise self._cannot_write(error) from None

    def _cannot_write(self, error: OSError) -> RecordingError:
        return RecordingError(f"{self.path}: recording stopped after {self.frames} messages: {error.strerror}")

    def __enter__(self) -> "Recorder":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self._connection.remove_observer(self._observe)
        try:
            self._writer.close()
        except OSError as reason:
            if error is None:
                raise self._cannot_write(reason) from None
