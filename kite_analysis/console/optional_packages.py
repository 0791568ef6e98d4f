"""Packages that only some uses need, and what is said where one is missing."""


class ExtraMissingError(Exception):
    """An optional package is not installed; the text says which, for what, and how to get it."""
