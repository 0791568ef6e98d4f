"""The wind: how it grows with height, how it changes with time, how it gusts."""
