"""The kites that can be flown, behind one interface."""
