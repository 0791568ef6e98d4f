"""Packages that only some uses need, and the message if one is missing."""


class ExtraMissingError(Exception):
    """An optional package is not installed; the text says which, for what, and how to get it."""
