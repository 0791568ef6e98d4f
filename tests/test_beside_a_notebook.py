"""A researcher's folder has an analysis.py, a plots.py, a tests/ of its own: none of them gets in the way of ours."""

import subprocess
import sys
from pathlib import Path

import pytest

THEIRS = ("analysis", "plots", "metrics", "delay", "scenario", "settings", "clock", "statistics", "file", "parameters")


@pytest.fixture
def their_folder(tmp_path):
    for name in THEIRS:
        (tmp_path / f"{name}.py").write_text("raise ImportError('theirs')\n")
    for name in ("tests", "docs"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("raise ImportError('theirs')\n")
    return tmp_path


@pytest.mark.parametrize("arguments", [
    ("-c", "import ground; from kite_analysis.delay.whole_loop import best_gains"),
    ("-m", "sim_bridge.cli.main", "list"), ("-m", "ground.cli.main", "--help"),
    ("-m", "sim_bridge.cli.main", "run", "paper-no-delay", "--duration", "1"),
], ids=lambda arguments: " ".join(arguments[1:3]))
def test_what_lies_in_the_users_folder_shadows_nothing(their_folder: Path, arguments):
    """`python -m` puts the user's folder first on the path, as a notebook does."""
    done = subprocess.run([sys.executable, *arguments], cwd=their_folder, capture_output=True, text=True, check=False)
    assert "theirs" not in done.stderr and done.returncode == 0, done.stderr
