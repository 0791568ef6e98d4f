"""The kite's state, estimated from samples: what is accepted, where the course comes from, K found in flight."""
