"""Options of `kite-sitl list` and `keys`."""

from argparse import ArgumentParser


def add_json_option(verb: ArgumentParser) -> None:
    """Add `--json`, which is all that these verbs take."""
    verb.add_argument("--json", action="store_true", help="print JSON for a script")
