"""The boards that the firmware runs on, behind one interface, and their settings."""
