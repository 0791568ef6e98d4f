"""Validation: the turning-rate law on real flights and on every plant, in tables made by one command."""
