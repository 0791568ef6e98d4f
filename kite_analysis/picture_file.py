"""Where a plot may be written: one rule for both programs."""

import os
from pathlib import Path

from kite_analysis.figures import new_figure

ENDINGS = (".png", ".svg", ".pdf", ".jpg")
ENDINGS_IN_WORDS = f"{', '.join(ENDINGS[:-1])} or {ENDINGS[-1]}"


class FileRefusedError(Exception):
    """A file cannot be written at the requested place; the text says why, in one line."""


def check_picture(path: Path, force: bool) -> None:
    """Check that a plot can be drawn and written to `path`, before the flight or the work that it shows.

    Raises:
        FileRefusedError: the ending names no format; or as `check_new_file`.
        ExtraMissingError: matplotlib is not installed.
    """
    if path.suffix.lower() not in ENDINGS:
        raise FileRefusedError(f"{path}: the name of a plot must end in {ENDINGS_IN_WORDS}")
    if path.is_dir():
        raise FileRefusedError(f"{path}: is a folder")
    check_new_file(path, force)
    new_figure()


def check_new_file(path: Path, force: bool) -> None:
    """Check that `path` can be written; a missing folder will be created.

    Raises:
        FileRefusedError: it exists and `force` is not set, or its folder is not writable.
    """
    if path.exists() and not force:
        raise FileRefusedError(f"{path}: already exists: give another name, or --force to overwrite it")
    nearest = next(there for there in (path, *path.absolute().parents) if there.exists())
    if nearest != path and not nearest.is_dir():
        raise FileRefusedError(f"{path}: {nearest} is not a folder")
    if not os.access(nearest, os.W_OK):
        raise FileRefusedError(f"{path}: Permission denied")
