"""The error that all rooms of the bridge share."""


class ScenarioError(Exception):
    """What was asked for cannot be flown; the text says what is wrong and where, in one line."""
