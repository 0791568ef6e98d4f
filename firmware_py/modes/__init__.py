"""Modes, and the fail-safes for missing samples, a silent ground station and low elevation."""
