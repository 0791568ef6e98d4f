"""Installing the firmware on a board: write its files, copy them, wait for its heartbeat."""
