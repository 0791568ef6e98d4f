"""The control laws: from a sample to the kite's state, the direction to fly, and the steering."""
