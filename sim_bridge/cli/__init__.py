"""The program `kite-sitl`: the table of verbs, a file for each group of them, and their options."""
