"""Where the firmware runs: in this process, in one of its own, on a board; all behind one interface."""
