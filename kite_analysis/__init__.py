"""Numerics shared by bridge and ground station: delay theory, metrics, flight files, plots. Pure functions."""
