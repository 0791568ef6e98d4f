"""The program `kite-ground`: the table of verbs, a file for each group of them, the monitor, the terminal."""
