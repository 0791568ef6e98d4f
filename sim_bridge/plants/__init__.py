"""The plants, behind one interface."""
