"""What is flown: the keys of a scenario, their defaults and bounds, and the sets that ship."""
