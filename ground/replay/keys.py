"""A replay in a terminal: its position, and keys that pause it and change its speed."""

import contextlib
import os
import select
import sys
from collections.abc import Callable
from types import TracebackType
from typing import TextIO

from ground.link.links import Clock
from ground.replay.player import Replay
from ground.vehicle.state import is_armed
from protocol.modes import mode_name

_LOOK_S = 0.1
_SHOW_EVERY_S = 0.25
_LONG_S = 3600.0


class Keys:
    """Single key presses, as a context manager; none if there is no terminal."""

    def __init__(self) -> None:
        self._restore: Callable[[], None] | None = None

    def __enter__(self) -> "Keys":
        with contextlib.suppress(ImportError, OSError, ValueError):  # not on Windows
            self._restore = _one_by_one(sys.stdin.fileno())
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        if self._restore is not None:
            self._restore()

    @property
    def there(self) -> bool:
        """Whether keys can be read."""
        return self._restore is not None

    def pressed(self) -> str:
        """The next key, or "" if none was pressed."""
        if self._restore is None or not select.select([sys.stdin], [], [], 0.0)[0]:
            return ""
        return os.read(sys.stdin.fileno(), 1).decode("ascii", "replace")


def run(replay: Replay, clock: Clock, output: TextIO) -> None:
    """Replay until the end, `q` or Ctrl-C; show progress on `output` if that is a terminal."""
    shown_s = float("-inf")
    with Keys() as keys, contextlib.suppress(KeyboardInterrupt):
        hint = "space pauses, + and - change the speed, q quits" if keys.there else "Ctrl-C ends"
        while replay.poll(_LOOK_S if keys.there else _LONG_S):
            key = keys.pressed()
            if key == "q":
                break
            _obey(replay, key)
            if output.isatty() and (key or clock() - shown_s >= _SHOW_EVERY_S):
                shown_s = clock()
                output.write(f"\r{status_line(replay)}   {hint}\x1b[K")
                output.flush()
    if output.isatty():
        output.write("\r\x1b[K")
        output.flush()


def status_line(replay: Replay) -> str:
    """Position and speed of a replay, and the vehicle's mode there."""
    beat = replay.beat
    state = f"{mode_name(beat.custom_mode)}, {'armed' if is_armed(beat) else 'disarmed'}" if beat is not None else ""
    pace = "paused" if replay.paused else f"speed {replay.speed:g}"
    return f"{minutes(replay.position_s)} of {minutes(replay.to_s)}   {pace}   {state}"


def minutes(seconds: float) -> str:
    """A time in minutes and seconds: 1:05.2."""
    tenths = round(seconds * 10.0)
    return f"{tenths // 600}:{tenths % 600 / 10.0:04.1f}"


def _obey(replay: Replay, key: str) -> None:
    if key == " ":
        replay.paused = not replay.paused
    elif key in ("+", "="):
        replay.speed *= 2.0
    elif key == "-":
        replay.speed /= 2.0


def _one_by_one(file: int) -> Callable[[], None]:
    """Read keys one by one; return a function that restores the terminal. Raises OSError if it is not a terminal."""
    import termios  # noqa: PLC0415  (not on Windows)
    import tty  # noqa: PLC0415

    if not os.isatty(file):
        raise OSError("no terminal")
    before = termios.tcgetattr(file)
    tty.setcbreak(file)
    return lambda: termios.tcsetattr(file, termios.TCSADRAIN, before)
