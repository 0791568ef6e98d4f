"""Text off the wire as a terminal may show it: whoever sends it must not move the cursor or fake a line."""

from functools import cache

from protocol import dialect

_REPLACEMENT = "\N{REPLACEMENT CHARACTER}"


def printable(text: str) -> str:
    """`text` with a replacement character for each escape, line break or other character that is not seen."""
    return text if text.isprintable() else "".join(letter if letter.isprintable() else _REPLACEMENT for letter in text)


def make_printable(message: dialect.MAVLink_message) -> None:
    """The same for all texts and names in `message`. Its frame stays as it came."""
    for field in _text_fields(type(message)):
        setattr(message, field, printable(getattr(message, field)))


@cache
def _text_fields(kind: type[dialect.MAVLink_message]) -> tuple[str, ...]:
    return tuple(name for name, field in zip(kind.fieldnames, kind.fieldtypes, strict=True) if field == "char")
