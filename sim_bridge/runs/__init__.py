"""Runs: a flight started, logged as it goes, summed up, read back."""
