"""The bench: what it compares, what it writes, and what it refuses."""

import json
import os
import sys

import pytest

from sim_bridge.cli.main import main
from sim_bridge.native.choice import COMPILED, INTERPRETED, VARIABLE, misfit_of_build

SHORT = ("bench", "--scenario", "small-kite", "--duration", "3")


@pytest.fixture
def loops(monkeypatch) -> set[str]:
    """The loops that there are here, of which the suite would see the sources only."""
    monkeypatch.setitem(os.environ, VARIABLE, "")
    return {INTERPRETED} if misfit_of_build() else {INTERPRETED, COMPILED}


def test_both_loops_are_flown_side_by_side_with_their_spread_and_ratio(loops, capsys):
    assert main([*SHORT, "--json"]) == 0
    flown = json.loads(capsys.readouterr().out)["scenarios"]["small-kite"]
    assert flown["speeds"].keys() == loops
    for speed in flown["speeds"].values():
        assert 1.0 < speed["least"] <= speed["median"] <= speed["most"]
        assert speed["tick_us"] > 0.0 < speed["step_us"]
    if COMPILED in loops:
        assert flown["ratios"]["compiled/interpreted"] > 3.0


def test_another_checkout_is_flown_beside_and_the_page_has_all_of_it(loops, tmp_path, capsys):
    other = tmp_path / "other"
    other.mkdir()
    (other / ".venv").symlink_to(sys.prefix)
    page = tmp_path / "speed.md"
    assert main([*SHORT, "--before", str(other), "--out", str(page)]) == 0
    _, head, row = capsys.readouterr().out.splitlines()
    assert "before" in head and row.startswith("small-kite ")
    text = page.read_text("utf-8")
    assert "| small-kite |" in text and "interpreted / before" in text
    assert main([*SHORT, "--out", str(page)]) == 2
    assert "already exists" in capsys.readouterr().err


@pytest.mark.parametrize(("words", "complaint"), [
    (("--runs", "3"), "--runs 3: fewer than 5 flights say little"),
    (("--scenario", "small-kit"), "no scenario small-kit; did you mean small-kite"),
    (("--before", "/nowhere"), "--before /nowhere: no .venv/bin/python there"),
    (("--interpreter", "/bin/micropython"), "only --runtime micropython has one")])
def test_what_cannot_be_measured_is_said_before_anything_is(words, complaint, capsys):
    assert main(["bench", *words]) == 2
    assert complaint in capsys.readouterr().err
