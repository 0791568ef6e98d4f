"""Prediction of the kite's state over the dead time, with the steering already sent."""
