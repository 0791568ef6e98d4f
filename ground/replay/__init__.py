"""Replay of a recorded flight to ground stations, as if the vehicle were flying."""
