"""Recorded flights: written, read, plotted, exported."""
