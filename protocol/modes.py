"""The kite's modes by their numbers and names, as KITE_MODE of the contract has them."""

from protocol import dialect

MODE_NAMES = {
    value: entry.name.removeprefix("KITE_MODE_")
    for value, entry in dialect.enums["KITE_MODE"].items()
    if value != dialect.KITE_MODE_ENUM_END
}


def mode_name(mode: int) -> str:
    """What a person calls this mode."""
    return MODE_NAMES.get(mode, f"mode {mode}")
