"""Equipment of the kite: sensors and the steering actuator."""
