"""What ground stations are told and may ask: inbox, dispatcher, a file for each kind of request, telemetry."""
