"""Number types for options, with error messages."""

from argparse import ArgumentTypeError


def number(text: str) -> float:
    """Any number."""
    try:
        return float(text)
    except ValueError:
        raise ArgumentTypeError(f"{text!r} is not a number") from None


def positive(text: str) -> float:
    """A finite number above 0."""
    value = number(text)
    if not 0.0 < value < float("inf"):
        raise ArgumentTypeError(f"{text} must be more than 0, and finite")
    return value


def not_negative(text: str) -> float:
    """A finite number, 0 or more."""
    value = number(text)
    if not 0.0 <= value < float("inf"):
        raise ArgumentTypeError(f"{text} must be 0 or more, and finite")
    return value


def count(text: str) -> int:
    """A whole number, 1 or more."""
    if not text.isdigit() or int(text) < 1:
        raise ArgumentTypeError(f"{text} is not a positive whole number")
    return int(text)
