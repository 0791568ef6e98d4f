"""The parameters: their values, and how they outlive a loss of power or a watchdog reset."""
