"""The firmware's types are all said, and in a form that CPython, MicroPython and mypyc take alike."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from sim_bridge.boards.constants import is_for_types

FOLDER = Path(__file__).parents[2] / "firmware_py"
FILES = sorted(FOLDER.rglob("*.py"))
EACH_FILE = pytest.mark.parametrize("text", [file.read_text("utf-8") for file in FILES],
                                    ids=[str(file.relative_to(FOLDER)) for file in FILES])
NEVER_COMPILED = ("interface.py", "settings.py")  # which may have classes for type checkers alone
NO_CONSTANT = ("TYPE_CHECKING", "MODULES")


def untyped(text: str) -> Iterator[str]:
    """Functions, parameters, attributes and constants of a module whose types are not said."""
    tree = ast.parse(text, type_comments=True)
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            yield from _untyped_function(node)
        elif isinstance(node, ast.ClassDef):
            yield from _untyped_attributes(node)
    for node in tree.body:
        match node:
            case ast.Assign(targets=[ast.Name(id=name)]) if name.isupper() and name not in NO_CONSTANT:
                if not (node.type_comment or "").startswith("Final"):
                    yield f"{name} is not Final"


def _untyped_function(function: ast.FunctionDef) -> Iterator[str]:
    of = function.args
    if function.returns is None:
        yield f"{function.name} returns what?"
    for argument in (*of.args, *of.kwonlyargs, *filter(None, (of.vararg, of.kwarg))):
        if argument.annotation is None and argument.arg != "self":
            yield f"{function.name}({argument.arg})"


def _untyped_attributes(kind: ast.ClassDef) -> Iterator[str]:
    """Attributes that are not annotated, nor a parameter, nor made by a class; and those made after `__init__`."""
    made = {name for node in kind.body for name in _names_set(node)}
    methods = [node for node in kind.body if isinstance(node, ast.FunctionDef)]
    for method in sorted(methods, key=lambda method: method.name != "__init__"):
        parameters = {argument.arg for argument in method.args.args}
        for node in ast.walk(method):
            for name in _attributes_set(node):
                if name not in made:
                    value = node.value if isinstance(node, ast.Assign | ast.AnnAssign) else None
                    typed = isinstance(node, ast.AnnAssign) or (isinstance(value, ast.Name) and value.id in parameters)
                    if method.name != "__init__":
                        yield f"{kind.name}.{name} is made in {method.name}"
                    elif not typed and not _makes(value):
                        yield f"{kind.name}.{name}"
                    made.add(name)


def _names_set(node: ast.stmt) -> Iterator[str]:
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    yield from (name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name))


def _attributes_set(node: ast.AST) -> Iterator[str]:
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    for part in (part for target in targets for part in ast.walk(target)):
        match part:
            case ast.Attribute(value=ast.Name(id="self"), attr=name, ctx=ast.Store()):
                yield name


def _makes(value: ast.expr | None) -> bool:
    """True for a call of a class: it says the type by itself."""
    return isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id.lstrip("_")[0].isupper()


def refused(text: str, name: str = "autopilot.py") -> Iterator[str]:
    """What MicroPython or mypyc cannot read: later Pythons' forms, classes for types alone, whole numbers as floats."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        match node:
            case ast.ImportFrom(module="__future__"):
                yield "from __future__"
            case ast.FunctionDef(args=ast.arguments(posonlyargs=[_, *_])):
                yield f"{node.name}: positional-only parameters"
            case ast.AnnAssign(annotation=ast.Name(id="float"), value=ast.Constant(value=int())):
                yield f"{ast.unparse(node)}: not a float"
            case ast.arguments():
                for argument, default in zip(reversed(node.args), reversed(node.defaults), strict=False):
                    match argument.annotation, default:
                        case ast.Name(id="float"), ast.Constant(value=int()):
                            yield f"{argument.arg}: its default is no float"
    for block in tree.body:
        has_class = is_for_types(block) and any(isinstance(node, ast.ClassDef) for node in ast.walk(block))
        if has_class and name not in NEVER_COMPILED:
            yield "a class for type checkers alone"


@EACH_FILE
def test_the_types_of_functions_attributes_and_constants_are_said(text):
    assert list(untyped(text)) == []


@pytest.mark.parametrize("file", FILES, ids=[str(file.relative_to(FOLDER)) for file in FILES])
def test_they_are_said_as_micropython_and_mypyc_read_them(file):
    assert list(refused(file.read_text("utf-8"), file.name)) == []


@pytest.mark.parametrize("line", [
    "def f(x) -> int:\n    return 1", "def f(x: int):\n    return 1", "LIMIT = 3", "LIMIT = 3  # of bytes",
    "class Kite:\n    def __init__(self, x: int) -> None:\n        self.x = x + 1",
    "class Kite:\n    def __init__(self, x: int) -> None:\n        self.x = self.y = x + 1",
    "class Kite:\n    def fly(self, x: int) -> None:\n        self.x = x"])
def test_what_is_not_said_is_found(line):
    assert list(untyped(line))


def test_what_says_its_type_by_itself_needs_no_annotation():
    assert not list(untyped("""
LIMIT = 3  # type: Final  # [us]

class Kite:
    height: float
    name = "kite"

    def __init__(self, wing: str, line: "Line") -> None:
        self.wing = wing
        self.line = Line()
        self.mass: float = 0.0

    def fly(self) -> None:
        self.height = self.mass = 3.0
        self.name = "other"
"""))


@pytest.mark.parametrize("text", [
    "from __future__ import annotations", "def f(x: int, /) -> int:\n    return x",
    "def f(x: float = 0) -> float:\n    return x",
    "class Kite:\n    def f(self) -> None:\n        self.mass: float = 1",
    "TYPE_CHECKING = False\nif TYPE_CHECKING:\n    class Kite:\n        mass: float"])
def test_what_micropython_or_mypyc_cannot_read_is_found(text):
    assert list(refused(text))
