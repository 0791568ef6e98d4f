"""The live monitor: a table that redraws itself in a terminal, a line a second anywhere else."""

import os
import shutil
from typing import TextIO

from ground import monitor_view
from ground.session import Session

_REDRAW_S = 0.2
_LINE_S = 1.0
_ALTERNATE_SCREEN, _NORMAL_SCREEN = "\x1b[?1049h\x1b[?25l", "\x1b[?25h\x1b[?1049l"
_HOME, _CLEAR_LINE, _CLEAR_BELOW = "\x1b[H", "\x1b[K", "\x1b[J"


def monitor(session: Session, output: TextIO, duration_s: float | None) -> None:
    """Show the vehicle on `output` for `duration_s` [s], or until interrupted when None."""
    if output.isatty() and os.environ.get("TERM") != "dumb":
        _show_table(session, output, duration_s)
    else:
        _print_lines(session, output, duration_s)


def _show_table(session: Session, output: TextIO, duration_s: float | None) -> None:
    end_s = _end(session, duration_s)
    output.write(_ALTERNATE_SCREEN)
    try:
        while session.connection.clock() < end_s:
            _serve(session, _REDRAW_S)
            width, height = shutil.get_terminal_size()
            lines = [line[: width - 1] for line in monitor_view.table(session.state, session.connection, session.link)]
            shown = [*lines[: height - 2], "", "  Ctrl-C ends"][:height]
            output.write(_HOME + "\n".join(f"{line}{_CLEAR_LINE}" for line in shown) + _CLEAR_BELOW)
            output.flush()
    finally:
        output.write(_NORMAL_SCREEN)
        output.flush()


def _print_lines(session: Session, output: TextIO, duration_s: float | None) -> None:
    start_s = session.connection.clock()
    end_s = _end(session, duration_s)
    shown_s = float("-inf")
    while session.connection.clock() < end_s:
        _serve(session, min(_LINE_S, end_s - session.connection.clock()))
        for text in [text for text in session.state.texts if text.time_s > shown_s]:
            output.write(f"t={text.time_s - start_s:.1f} {text.severity_name}: {text.text}\n")
            shown_s = text.time_s
        elapsed_s = session.connection.clock() - start_s
        output.write(monitor_view.line(session.state, session.connection, elapsed_s) + "\n")
        output.flush()


def _end(session: Session, duration_s: float | None) -> float:
    return session.connection.clock() + (float("inf") if duration_s is None else duration_s)


def _serve(session: Session, seconds: float) -> None:
    """Let the connection work for this long [s]."""
    session.connection.wait_until(lambda: False, seconds)
