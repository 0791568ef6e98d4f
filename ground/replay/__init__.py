"""A recorded flight played back to ground stations, as if the vehicle were there."""
