"""The option --plot, for every verb that draws."""

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from kite_analysis.figures import save
from kite_analysis.picture_file import ENDINGS_IN_WORDS, check_picture
from sim_bridge.errors import ScenarioError

_INPUTS = ("", ".toml", ".csv", ".gz", ".tlog")  # endings of what the verbs read; a folder or scenario has none


def add_plot_option(verb: ArgumentParser, what: str, default: str) -> None:
    """Add --plot [FILE] and --force; `what` is drawn into `default` where no file is named."""
    verb.add_argument("--plot", nargs="?", const="", metavar="FILE",
                      help=f"{what} (default: {default}); {ENDINGS_IN_WORDS} names the format")
    verb.add_argument("--force", action="store_true", help="let --plot overwrite an existing file")


def leave_words_to_others(arguments: Sequence[str]) -> list[str]:
    """`--plot` does not take a word that names what is to be drawn: `run --plot paper-delay` names a scenario."""
    words = list(arguments)
    for index, word in enumerate(words[:-1]):
        if word == "--plot" and Path(words[index + 1]).suffix.lower() in _INPUTS:
            words[index] = "--plot="
    return words


def plot_path(options: Namespace, default: Path) -> Path | None:
    """Where to draw, seen to be possible; None where no plot was asked for. Raises as `check_picture` does."""
    if options.plot is None:
        return None
    path = Path(options.plot) if options.plot else default
    check_picture(path, options.force)
    return path


def save_plot(figure: Any, path: Path) -> None:
    """Write `figure`. Raises ScenarioError if the disk refuses it."""
    try:
        save(figure, path)
    except OSError as error:
        raise ScenarioError(f"--plot {path}: {error.strerror or error}") from error
