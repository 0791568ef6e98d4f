"""Sensors and actuators at a board's pins."""
