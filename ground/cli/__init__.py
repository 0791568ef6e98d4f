"""The program `kite-ground`: a file for each group of verbs, the monitor, the terminal."""
