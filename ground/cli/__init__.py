"""The command `kite-ground`: a file for each group of subcommands, the monitor, the terminal."""
