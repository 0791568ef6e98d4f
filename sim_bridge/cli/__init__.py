"""The program `kite-sitl`: a file for each group of verbs, and the options that they share."""
