"""Records every received frame to a tlog."""

from pathlib import Path
from types import TracebackType

from ground.errors import GroundError, UsageError
from ground.link.connection import GROUND_COMPONENT, GROUND_SYSTEM, Connection
from ground.link.framing import Message
from kite_analysis.flights.tlog import TlogWriter
from protocol import dialect

_FLUSH_S = 1.0


class RecordingError(GroundError):
    """The file can no longer be written; earlier messages are in it."""


class Recorder:
    """Records everything that a connection receives to the tlog at `path`, as a context manager.

    The connection's clock plus `epoch_offset_s` is seconds since 1970 (UTC). The first frame is a TIMESYNC of this
    ground station with its own clock: from it and the answers that follow, a reader computes round trips. Data are
    handed to the operating system once a second, so that a kill loses no more than that.

    Raises:
        UsageError: the file exists and `overwrite` is not set, or it cannot be created.
        RecordingError: from within the connection's `poll`, if the file can no longer be written.
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
        """Time since the recording began [s]."""
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
