"""The wind: profile over height, planned changes, gusts."""
