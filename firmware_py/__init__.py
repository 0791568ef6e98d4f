"""The kite's autopilot: everything that goes onto the board, and nothing else."""
