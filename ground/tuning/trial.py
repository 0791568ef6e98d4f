"""Parameters that are tried in flight: whatever was set is put back, on every way out but one."""

import contextlib
import signal
import threading
from collections.abc import Callable
from types import FrameType, TracebackType

from ground.errors import GroundError, NoAnswerError, VehicleError
from ground.parameters.file import format_value
from ground.session import Session
from protocol.parameter_table import float32

UNDO_S = 30.0  # for a link that is down to come back
_SIGNALS = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))

Told = Callable[[str], None]


class Trial:
    """A context in which parameters are `set`; at its end they are as they were before, unless it was told to `keep`.

    Its end comes by an exception, Ctrl-C, SIGTERM or the terminal's end too (in the main thread; the process exits with
    128 and the signal's number then). A second Ctrl-C does not stop it from putting the values back.

    Raises, at its end:
        VehicleError: a value that was put back was not acknowledged; says how to do it by hand. Where another
            exception is under way already, that is `told` instead.
    """

    def __init__(self, session: Session, told: Told = lambda text: None) -> None:
        self._session, self._told = session, told
        self._before: dict[str, float] = {}
        self._tried: dict[str, float] = {}
        self._handlers: dict[int, object] = {}

    def set(self, name: str, value: float) -> float:
        """Set a parameter, and return its value before. Raises VehicleError where the vehicle refuses."""
        before = self._session.parameters.fetch(name)
        self._before.setdefault(name, before)  # from here on: a value that nobody acknowledged may be in force
        self._tried[name] = float32(value)
        self._session.parameters.set(name, float32(value))
        return before

    def keep(self) -> None:
        """What was set stays."""
        self._before.clear()

    def undo(self) -> None:
        """Put back what was before, the last set first. Raises VehicleError as the context's end does."""
        with self._undisturbed():
            until_s = self._session.connection.clock() + UNDO_S
            for name in reversed(list(self._before)):
                self._put_back(name, until_s)
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

    def _put_back(self, name: str, until_s: float) -> None:
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
        """Until the values are back, Ctrl-C and the like are answered, not obeyed."""
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
        with contextlib.suppress(OSError, ValueError):  # a terminal that is gone must not keep us from it
            self._told(text)


def _leave(number: int, frame: FrameType | None) -> None:
    raise SystemExit(128 + number)
