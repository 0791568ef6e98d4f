"""Recorded flights, real and simulated, read into one form, in our frames, signs and units."""
