"""The vehicle: its state, its flight so far, and commands to it."""
