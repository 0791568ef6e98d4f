"""Number types for options, with error messages, and an option of several verbs."""

from argparse import ArgumentParser, ArgumentTypeError


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


def add_interpreter_option(verb: ArgumentParser, default: str = "the one beside Python") -> None:
    """Add `--interpreter`, for verbs that fly with the runtime `micropython`."""
    verb.add_argument("--interpreter", metavar="PATH",
                      help="the MicroPython of --runtime micropython, such as a build with single-precision floats "
                      f"(docs/boards.md; default: {default})")


def add_loop_option(verb: ArgumentParser) -> None:
    """The option for which loop flies: for verbs that fly."""
    verb.add_argument("--interpreted", action="store_true",
                      help="do not use the compiled loop (`make compiled`); the numbers are the same, to the bit")
