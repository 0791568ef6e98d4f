"""Messages of `kite-sitl` besides the result."""

import errno
import sys
from typing import TextIO

DISK_TROUBLE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)  # output goes to a file that takes no more


def notice(text: str) -> None:
    """A line on the error stream."""
    say(f"kite-sitl: {text}", sys.stderr)


def say(text: str, stream: TextIO | None = None) -> None:
    """A line in flight, on stdout by default: that it cannot be written must not end the flight."""
    try:
        print(text, file=stream, flush=True)
    except OSError as error:
        if error.errno not in DISK_TROUBLE:
            raise
