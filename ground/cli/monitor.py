"""The live monitor: a table in a terminal, one line per second in a pipe."""

import os
from typing import TextIO

from ground.cli import monitor_view
from ground.health import Advisor
from ground.session import Session

_REDRAW_S = 0.2
_LINE_S = 1.0
_ALTERNATE_SCREEN, _NORMAL_SCREEN = "\x1b[?1049h\x1b[?25l", "\x1b[?25h\x1b[?1049l"
_HOME, _CLEAR_LINE, _CLEAR_BELOW, _CLEAR_ALL = "\x1b[H", "\x1b[K", "\x1b[J", "\x1b[2J"


def monitor(session: Session, output: TextIO, duration_s: float | None) -> None:
    """Show the vehicle on `output` for `duration_s` [s], or until interrupted if None."""
    if output.isatty() and os.environ.get("TERM") != "dumb":
        _show_table(session, output, duration_s)
    else:
        _print_lines(session, output, duration_s)


def _show_table(session: Session, output: TextIO, duration_s: float | None) -> None:
    end_s = _end(session, duration_s)
    advisor, size = Advisor(session), (0, 0)
    session.on_notice = lambda text: None  # the table shows it
    output.write(_ALTERNATE_SCREEN)
    try:
        while session.connection.clock() < end_s:
            _serve(session, _REDRAW_S)
            before, size = size, _size(output)
            lines = monitor_view.screen(session, advisor.warnings(), *size)
            output.write((_HOME if size == before else _CLEAR_ALL + _HOME)
                         + "\r\n".join(f"{line}{_CLEAR_LINE}" for line in lines) + _CLEAR_BELOW)
            output.flush()
    finally:
        output.write(_NORMAL_SCREEN)
        output.flush()


def _print_lines(session: Session, output: TextIO, duration_s: float | None) -> None:
    start_s = session.connection.clock()
    end_s = _end(session, duration_s)
    shown_s, warned = float("-inf"), []
    advisor = Advisor(session)
    while session.connection.clock() < end_s:
        _serve(session, min(_LINE_S, end_s - session.connection.clock()))
        for text in [text for text in session.state.texts if text.time_s > shown_s]:
            output.write(f"t={text.time_s - start_s:.1f} {text.severity_name}: {text.text}\n")
            shown_s = text.time_s
        elapsed_s = session.connection.clock() - start_s
        warnings = advisor.warnings()
        for text in [text for text in warnings if _kind(text) not in warned]:
            output.write(f"t={elapsed_s:.1f} WARNING: {text}\n")
        warned = [_kind(text) for text in warnings]
        output.write(monitor_view.line(session.state, session.connection, elapsed_s) + "\n")
        output.flush()


def _kind(warning: str) -> str:
    """The warning without its numbers, which vary."""
    return "".join(letter for letter in warning if not letter.isdigit())


def _size(output: TextIO) -> tuple[int, int]:
    """Present columns and rows of the terminal."""
    try:
        size = os.get_terminal_size(output.fileno())
    except OSError:
        return 80, 24
    return size.columns or 80, size.lines or 24


def _end(session: Session, duration_s: float | None) -> float:
    return session.connection.clock() + (float("inf") if duration_s is None else duration_s)


def _serve(session: Session, seconds: float) -> None:
    """Serve the connection for `seconds` [s]."""
    session.connection.wait_until(lambda: False, seconds)
