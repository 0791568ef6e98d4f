"""The ground station: link, vehicle state, parameters, tuning, recorder, command line."""
