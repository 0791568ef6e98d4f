"""The parameters: their values, and their storage across power loss and watchdog reset."""
