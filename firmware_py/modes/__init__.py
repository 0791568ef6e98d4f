"""Which mode holds, and what happens when samples, the ground station or height are missing."""
