"""Fields have names: no message, request, sample, state or row is read by a number.

A subscript that is a number is for vectors and for the ends of lists. What has fields is a NamedTuple, or is unpacked
into names. The rule, on the syntax tree, for a constant integer n:

    x[2], x[-3]         refused, whatever x is: nobody counts to three in a list
    sample[0]           refused where x is called as what has fields, see HAS_FIELDS
    rows[-1][0]         refused: a field of an element
    measure(...)[1]     refused: a part of a result
"""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
HELD = ("firmware_py", "ground", "kite_analysis", "sim_bridge", "protocol")
# What is generated, runs on MicroPython alone, or has three coordinates wherever it has a subscript.
EXEMPT = ("protocol/dialect.py", "sim_bridge/bench/on_micropython.py", "sim_bridge/plants/")
HAS_FIELDS = {
    "answer", "change", "clock", "command", "entry", "event", "first", "frame", "head", "header", "kept", "last",
    "message", "newest", "observer", "oldest", "output", "question", "record", "reply", "request", "result", "row",
    "sample", "sender", "settings", "state", "told", "vehicle_clock", "wired",
}
OF_A_MESSAGE = {"values", "fields"}  # unless they are somebody's: an axis has values too
ENDS = (0, 1, -1, -2)


def refused(tree: ast.AST) -> Iterator[ast.Subscript]:
    """The subscripts that read a field by its number."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Subscript) and (number := constant(node.slice)) is not None:
            of = node.value
            name = of.id if isinstance(of, ast.Name) else of.attr if isinstance(of, ast.Attribute) else ""
            is_field = name.lstrip("_") in HAS_FIELDS or (isinstance(of, ast.Name) and name in OF_A_MESSAGE)
            of_element = isinstance(of, ast.Subscript) and constant(of.slice) is not None
            of_result = isinstance(of, ast.Call) and number not in (0, -1)
            if number not in ENDS or is_field or of_element or of_result:
                yield node


def constant(index: ast.expr) -> int | None:
    """The number that an index is, if it is one."""
    try:
        value = ast.literal_eval(index)
    except ValueError:
        return None
    return value if type(value) is int else None


def files() -> list[Path]:
    found = [path for folder in HELD for path in sorted((ROOT / folder).rglob("*.py"))]
    return [path for path in found if not str(path.relative_to(ROOT)).startswith(EXEMPT)]


def test_no_field_is_read_by_its_number():
    assert len(files()) > 150
    found = [f"{path.relative_to(ROOT)}:{node.lineno}: {ast.unparse(node)}"
             for path in files() for node in refused(ast.parse(path.read_text("utf-8")))]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(("text", "count"), [
    ("values[7]", 1), ("output.state[14]", 1), ("self._states[-1][1]", 1), ("sample[0]", 1), ("rows[0][0]", 1),
    ("f(x)[1]", 1), ("found[2]", 1), ("d[-3]", 1),
    ("time_s[0]", 0), ("time_s[-1]", 0), ("problems[0]", 0), ("text.split()[0]", 0), ("rows[index][name]", 0),
    ("frame[4:]", 0), ("array[..., 2]", 0), ("states['time_s'][-1]", 0)])
def test_the_rule_sees_what_it_should(text, count):
    assert len(list(refused(ast.parse(text)))) == count
