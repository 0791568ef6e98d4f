"""The control laws: which way to fly to the eight, how to steer that way, and with which gains."""
