"""The verb `validate` of `kite-sitl`: what the models are worth, as a page of tables."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from kite_analysis.picture_file import check_new_file
from sim_bridge.cli.notes import notice
from sim_bridge.errors import ScenarioError
from sim_bridge.studies.validation.page import page


def add_validate_verb(verbs: Any) -> None:
    """Add `validate` to the verbs of `kite-sitl`."""
    verb = verbs.add_parser(
        "validate", help="compare the turning-rate law and the plants with real flights and each other, in a page of "
                        "tables",
        description="Identify the turning-rate law on real flights and on every plant, fly them, and write the tables "
        "as a Markdown page. Takes some minutes.")
    verb.add_argument("files", nargs="+", metavar="FLIGHT", help="two or more real flights, CSV or CSV.gz")
    verb.add_argument("--out", metavar="FILE.md", default="validation.md", help="the page (default: validation.md)")
    verb.add_argument("--force", action="store_true", help="overwrite an existing page")
    verb.set_defaults(do=validate_command)


def validate_command(options: Namespace) -> int:
    """`kite-sitl validate`."""
    if len(options.files) < 2:
        raise ScenarioError("validate: at least two flights are needed, so that one can be predicted from another")
    check_new_file(Path(options.out), options.force)
    text = page([Path(name) for name in options.files], notice)
    try:
        Path(options.out).write_text(text, "utf-8")
    except OSError as error:
        raise ScenarioError(f"--out {options.out}: {error.strerror}") from error
    print(f"tables: {options.out}")
    return 0
