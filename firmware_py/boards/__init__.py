"""The boards that the firmware runs on, behind one interface, and the settings of their users."""
