"""What can go wrong in a way that a person should read about: every message is one line, whole in itself."""


class GroundError(Exception):
    """An error to be shown as it is, without a traceback. `exit_code` is what the command line ends with."""

    exit_code = 1


class UsageError(GroundError):
    """What was given is wrong, or nothing is there to talk to: a link, a name, a number, a file."""

    exit_code = 2


class VehicleError(GroundError):
    """The vehicle refused, or did not answer."""


class NoAnswerError(VehicleError):
    """The vehicle did not answer, however often it was asked."""
