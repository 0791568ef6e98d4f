"""Putting the firmware onto a board: lay out its files, copy them, hear it answer."""
