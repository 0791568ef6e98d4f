"""Trials of parameters in flight: the old values are restored on every way out but `keep`."""

import contextlib
import signal
import threading
from collections.abc import Callable
from types import FrameType, TracebackType

from ground.errors import GroundError, NoAnswerError, VehicleError
from ground.parameters.file import format_value
from ground.session import Session
from protocol.single_precision import float32

UNDO_S = 30.0  # how long to wait for a link to come back
_SIGNALS = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))

Told = Callable[[str], None]


class Trial:
    """A context in which parameters are `set`; at its end the old values are restored, unless `keep` was called.

    That includes exceptions, Ctrl-C, SIGTERM and a closed terminal (in the main thread; the process then exits with 128
    plus the signal's number). A second Ctrl-C does not interrupt the restoring.

    Raises, at its end:
        VehicleError: a restored value was not acknowledged; says how to restore it by hand. If another exception is
            under way already, this goes to `told` instead.
    """

    def __init__(self, session: Session, told: Told = lambda text: None) -> None:
        self._session, self._told = session, told
        self._before: dict[str, float] = {}
        self._tried: dict[str, float] = {}
        self._handlers: dict[int, object] = {}

    def set(self, name: str, value: float) -> float:
        """Set a parameter, and return its old value. Raises VehicleError if the vehicle refuses."""
        before = self._session.parameters.fetch(name)
        self._before.setdefault(name, before)  # from here on, even an unacknowledged value may apply
        self._tried[name] = float32(value)
        self._session.parameters.set(name, float32(value))
        return before

    def keep(self) -> None:
        """Let the new values stay."""
        self._before.clear()

    def undo(self) -> None:
        """Restore the old values, in reverse order. Raises VehicleError as the end of the context does."""
        with self._undisturbed():
            until_s = self._session.connection.clock() + UNDO_S
            for name in reversed(list(self._before)):
                self._restore(name, until_s)
        left, self._before = self._before, {}
        if left:
            what = ", ".join(f"{name} (tried: {format_value(self._tried[name])})" for name in left)
            by_hand = " && ".join(f"kite-ground param set {name} {format_value(value)}"
                                  for name, value in reversed(left.items()))
            raise VehicleError(f"NOT UNDONE, not acknowledged by the kite: {what}; "
                               f"when it is heard again, run: {by_hand}")

    def __enter__(self) -> "Trial":
        if threading.current_thread() is threading.main_thread():
            self._handlers = {number: signal.signal(number, _leave) for number in _SIGNALS}
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        try:
            self.undo()
        except VehicleError as left:
            if error is None:
                raise
            self._say(f"{left}")
        finally:
            for number, handler in self._handlers.items():
                signal.signal(number, handler)  # type: ignore[arg-type]

    def _restore(self, name: str, until_s: float) -> None:
        value = self._before[name]
        while True:
            try:
                self._session.parameters.set(name, value)
            except NoAnswerError as error:
                if self._session.connection.clock() >= until_s:
                    return
                self._say(f"{error}; restoring {name} = {format_value(value)}")
            except GroundError as error:
                self._say(f"{error}")
                return
            else:
                del self._before[name]
                self._say(f"{name} = {format_value(value)} restored, acknowledged by the kite")
                return

    @contextlib.contextmanager
    def _undisturbed(self):
        """Until the values are restored, Ctrl-C and other signals are answered but not obeyed."""
        if not self._before or threading.current_thread() is not threading.main_thread():
            yield
            return

        def wait(number: int, frame: FrameType | None) -> None:
            self._say("restoring the old values: please wait")

        before = {number: signal.signal(number, wait) for number in (signal.SIGINT, *_SIGNALS)}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    def _say(self, text: str) -> None:
        with contextlib.suppress(OSError, ValueError):  # a closed terminal must not prevent the restoring
            self._told(text)


def _leave(number: int, frame: FrameType | None) -> None:
    raise SystemExit(128 + number)
