"""Messages to and from ground stations: inbox, dispatcher, a file for each kind of request, telemetry."""
