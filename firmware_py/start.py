"""What /main.py imports on a board, and nothing else does: importing it starts the firmware."""

import sys

from .startup import start

start(sys.platform)
