"""Gains for the delay in the loop: measured in flight, advised, tried, undone."""
