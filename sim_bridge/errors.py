"""The errors that `kite-sitl` answers with one line: whoever raises one, and whoever catches it, imports no more."""


class ScenarioError(Exception):
    """What was asked for cannot be flown; the text says what is wrong and where, in one line."""


class FirmwareError(Exception):
    """The firmware cannot be started, fell silent, or answered the wrong tick; the text says so in one line."""


class BoardError(Exception):
    """A problem with a board that the user can fix; the text says what."""
