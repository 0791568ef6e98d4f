"""The turning-rate law and the steering actuator, identified from a recorded flight."""
