"""How fast it goes, and what a tick costs under MicroPython."""
