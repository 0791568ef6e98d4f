"""Serves a connection between calls, so that the kite hears our heartbeat and no message is missed."""

import contextlib
import threading
from collections.abc import Iterator

from ground.link.connection import Connection

_SLICE_S = 0.02
_GIVE_WAY_S = 0.002


class Background:
    """Serves `connection` in a thread, except while a caller has it `held`. Does nothing until `start`.

    An error in the thread ends it, and is raised in the next caller.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._lock = threading.RLock()
        self._counting = threading.Lock()
        self._callers = 0
        self._over = threading.Event()
        self._error: Exception | None = None
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Start the thread."""
        self._thread = threading.Thread(target=self._serve, name="ground station", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Stop the thread. May be called twice, and from within it."""
        self._over.set()
        if self._thread and self._thread is not threading.current_thread():
            self._thread.join()

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """Have the connection to oneself; may be nested."""
        with self._counting:
            self._callers += 1  # the thread lets go at once
        try:
            with self._lock:
                if self._error:
                    raise self._error
                yield
        finally:
            with self._counting:
                self._callers -= 1

    def _serve(self) -> None:
        while not self._over.is_set():
            if self._callers > 0:
                self._over.wait(_GIVE_WAY_S)
                continue
            with self._lock:
                try:
                    self._connection.poll(_SLICE_S)
                except Exception as error:  # of any kind: the user must see it, not a thread that is gone
                    self._error = error
                    return
