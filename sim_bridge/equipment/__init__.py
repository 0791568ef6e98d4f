"""What the kite carries: sensors and the steering actuator."""
