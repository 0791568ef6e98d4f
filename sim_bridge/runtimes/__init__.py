"""Runtimes: the firmware in this process, in its own process or on a board, behind one interface."""
