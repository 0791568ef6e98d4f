"""MicroPython 1.28 is what boards run: what only came later is refused, though the interpreter here may have it."""

import ast
from pathlib import Path

import pytest

FIRMWARE = sorted((Path(__file__).parent.parent.parent / "firmware_py").rglob("*.py"))
SIGNED = ("to_bytes", "from_bytes")  # `signed` came with 1.29


def later_than_1_28(source: str) -> list[str]:
    found = []
    for node in ast.walk(ast.parse(source)):
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in SIGNED):
            continue
        if len(node.args) > 2 or any(keyword.arg == "signed" for keyword in node.keywords):
            found.append(f"line {node.lineno}: {node.func.attr}(signed=...)")
    return found


@pytest.mark.parametrize("path", FIRMWARE, ids=[path.name for path in FIRMWARE])
def test_nothing_is_used_that_came_after_1_28(path):
    assert later_than_1_28(path.read_text("utf-8")) == []


@pytest.mark.parametrize("line", ['x.to_bytes(4, "little", signed=True)', 'int.from_bytes(b, "big", signed=True)',
                                  'x.to_bytes(4, "little", True)'])
def test_the_check_sees_it(line):
    assert later_than_1_28(f"def f(x, b):\n    return {line}\n")
    assert not later_than_1_28('x = 5\ny = x.to_bytes(4, "little")\n')
