"""Dialogue with the user: a question, a remark, the progress of a long fetch."""

import select
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ground.parameters.listing import Progress
    from ground.session import Session

_LOOK_S = 0.1


def confirm(session: "Session", question: str) -> bool:
    """Ask on stderr, and serve the link until the answer: a kite that misses its ground station may park."""
    print(f"{question} [y/N] ", end="", file=sys.stderr, flush=True)
    while not _input_is_ready():
        session.connection.poll(_LOOK_S)
    answer = sys.stdin.readline()
    if not answer.endswith("\n"):
        print(file=sys.stderr)
    return answer.strip().lower() in ("y", "yes")


def tell(text: str) -> None:
    """Print a remark on stderr, apart from results."""
    print(text, file=sys.stderr, flush=True)


def parameter_progress() -> "Progress | None":
    """A callback that shows "n of total" on stderr while parameters load; None if that is not a terminal."""
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
        return True  # cannot be waited for (Windows, or not a file): just read
