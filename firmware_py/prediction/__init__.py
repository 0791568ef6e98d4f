"""The kite's state carried forward over the dead time, with the steering that is still on its way."""
