"""docs/architecture.md shows the imports as they are, and every room of the house is in it."""

from pathlib import Path

import architecture
import pytest

ROOT = Path(__file__).parent.parent


def test_the_pictures_are_those_of_the_imports():
    """Drawn by `make architecture`."""
    page = architecture.PAGE.read_text("utf-8")
    assert architecture.drawn(page) == page and page.count("```mermaid") == len(architecture.HOUSE)


@pytest.mark.parametrize("package", ["firmware_py", "ground", "kite_analysis", "sim_bridge"])
def test_no_room_is_left_out_and_no_folder_stands_beside_a_module_of_its_name(package):
    page = architecture.PAGE.read_text("utf-8")
    rooms = [path.parent for path in (ROOT / package).glob("*/__init__.py")]
    assert rooms
    for room in rooms:
        assert f"`{room.name}/`" in page, room
    for folder in {path.parent for path in (ROOT / package).rglob("__init__.py")}:
        assert not folder.with_suffix(".py").exists(), folder
    for path in (ROOT / package).rglob("*.py"):
        assert path.parent == ROOT / package or (path.parent / "__init__.py").exists(), path


def test_an_arrow_that_a_longer_way_implies_is_left_out():
    assert architecture.reduced({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == {"a": {"b"}, "b": {"c"}, "c": set()}
    circle = {"a": {"b"}, "b": {"a"}}
    assert architecture.reduced(circle) == circle
