"""The vehicle's parameters: fetched, set, watched, compared, kept in files."""
