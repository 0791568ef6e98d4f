"""Runs: start a flight, log it, summarise it, read it back."""
