"""Many flights: a grid or a random sample over scenario keys and parameters, on all cores or on a cluster."""
