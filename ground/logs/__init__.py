"""Recorded flights: recording, reading, plots, exports."""
