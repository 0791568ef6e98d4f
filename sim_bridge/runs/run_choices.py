"""What the options of a run offer, and what they are without it."""

ONLY_MICROPYTHON = "--interpreter: only --runtime micropython has one"
RUNTIMES = ("inproc", "cpython", "micropython")
FOREVER_LIMIT_MB = 500.0  # of a log, for a flight that nobody may ever end: some five hours
