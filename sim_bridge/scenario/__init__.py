"""Scenarios: keys, defaults, bounds, and the sets that come with kitepilot."""
