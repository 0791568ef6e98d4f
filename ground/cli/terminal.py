"""Talking with the person at the terminal: a question, and how far a long fetch has come."""

import select
import sys

from ground.parameters.client import Progress
from ground.session import Session

_LOOK_S = 0.1


def confirm(session: Session, question: str) -> bool:
    """Ask on stderr, and serve the link until the answer is there: a kite that misses its ground station may park."""
    print(f"{question} [y/N] ", end="", file=sys.stderr, flush=True)
    while not _input_is_ready():
        session.connection.poll(_LOOK_S)
    answer = sys.stdin.readline()
    if not answer.endswith("\n"):
        print(file=sys.stderr)
    return answer.strip().lower() in ("y", "yes")


def tell(text: str) -> None:
    """A remark that is no result, on stderr."""
    print(text, file=sys.stderr, flush=True)


def parameter_progress() -> Progress | None:
    """Shows "n of total" on a terminal's stderr while parameters load, and wipes it out at the end."""
    if not sys.stderr.isatty():
        return None

    def show(count: int, total: int) -> None:
        text = f"\r{count} of {total} parameters" if count < total else "\r\x1b[K"
        print(text, end="", file=sys.stderr, flush=True)

    return show


def _input_is_ready() -> bool:
    try:
        return bool(select.select([sys.stdin], [], [], 0.0)[0])
    except (OSError, ValueError):
        return True  # not to be waited for here (Windows, or no real file): just read it
