"""What is known about the vehicle, whether it is well, and commands to it."""
