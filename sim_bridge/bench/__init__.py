"""Benchmarks: simulation speed, and the cost of a tick under MicroPython."""
