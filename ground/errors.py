"""Errors for the user to read: every message is one line that needs no context."""


class GroundError(Exception):
    """An error to show without a traceback. `exit_code` is the exit code of the command line."""

    exit_code = 1


class UsageError(GroundError):
    """Wrong input (a link, a name, a number, a file), or no vehicle to talk to."""

    exit_code = 2


class VehicleError(GroundError):
    """The vehicle refused, or did not answer."""


class NoAnswerError(VehicleError):
    """The vehicle did not answer any of several requests."""
