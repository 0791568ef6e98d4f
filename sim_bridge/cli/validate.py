"""The verb `validate` of `kite-sitl`: what the models are worth, as a page of tables."""

from argparse import Namespace
from pathlib import Path

from kite_analysis.picture_file import check_new_file
from sim_bridge.cli.notes import notice
from sim_bridge.errors import ScenarioError
from sim_bridge.studies.validation.page import page


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
