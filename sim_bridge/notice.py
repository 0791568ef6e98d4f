"""How `kite-sitl` tells a person something beside the result."""

import sys


def notice(text: str) -> None:
    """A line on the error stream."""
    print(f"kite-sitl: {text}", file=sys.stderr, flush=True)
