"""Puts the firmware's constants in where they are used, before it is compiled for a board.

MicroPython looks a module's constant up by its name, each time, and keeps the name on the heap. What `mpy-cross` cannot
do, since it sees one file at a time, is done here: a name that a module sets once to a number becomes that number, in
its own module and in those that import it, and its definition goes. So does what only type checkers look at, under
`if TYPE_CHECKING:`. Lines stay where they are, so that a traceback names the right one.
"""

import ast
from collections import Counter
from collections.abc import Iterable, Iterator
from typing import NamedTuple

Number = int | float
_OPERATORS = {
    ast.Add: lambda a, b: a + b, ast.Sub: lambda a, b: a - b, ast.Mult: lambda a, b: a * b,
    ast.FloorDiv: lambda a, b: a // b, ast.LShift: lambda a, b: a << b, ast.BitOr: lambda a, b: a | b,
}


class _Edit(NamedTuple):
    """Text to put in the place of what stands from (line, column) to (line, column), columns in bytes."""

    start: tuple[int, int]
    end: tuple[int, int]
    text: str


def imported_module(importer: str, node: ast.ImportFrom, is_package: bool = False) -> str:
    """Full name of the module that `node` imports from, in the module `importer` or, if `is_package`, its own file."""
    if not node.level:
        return node.module or ""
    parts = importer.split(".")
    package = parts[: len(parts) - node.level + is_package]
    return ".".join([*package, *([node.module] if node.module else [])])


def is_for_types(node: ast.stmt) -> bool:
    """True for what a module has for type checkers alone: `TYPE_CHECKING = False`, and what is under it."""
    match node:
        case ast.Assign(targets=[ast.Name(id="TYPE_CHECKING")]) | ast.If(test=ast.Name(id="TYPE_CHECKING"), orelse=[]):
            return True
    return False


def is_types_only(text: str) -> bool:
    """True for the text of a module that holds nothing but types: no board needs it."""
    first, *rest = ast.parse(text).body or [ast.Pass()]
    return isinstance(first, ast.Expr) and bool(rest) and all(map(is_for_types, rest))


def imported_names(importer: str, nodes: Iterable[ast.AST], is_package: bool = False) -> Iterator[str]:
    """Full names of what the statements among `nodes` of the module `importer` import: modules, or names in them."""
    for node in nodes:
        if isinstance(node, ast.ImportFrom):
            source = imported_module(importer, node, is_package)
            yield source
            yield from (f"{source}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


class _Module:
    """A source file: its constants by name, and where they are set."""

    def __init__(self, name: str, is_package: bool, text: str):
        self.name = name
        self.text = text
        self.tree = ast.parse(text)
        self.types = [node for node in self.tree.body if is_for_types(node)]
        self.tree.body = [node for node in self.tree.body if not is_for_types(node)]
        self.constants: dict[str, Number] = {}
        self.definitions: dict[str, ast.Assign] = {}
        self.imports = [node for node in self.tree.body if isinstance(node, ast.ImportFrom)]
        self._is_package = is_package
        self._bound = Counter(_bound_names(self.tree))
        self._in_texts = {
            name.id for text in ast.walk(self.tree) if isinstance(text, ast.JoinedStr)
            for name in ast.walk(text) if isinstance(name, ast.Name)}

    def source_of(self, node: ast.ImportFrom) -> str:
        """Full name of the module that an import statement names."""
        return imported_module(self.name, node, self._is_package)

    def may_be_constant(self, name: str) -> bool:
        """True for a name that is bound once, and not used where no number can be put in."""
        return self._bound[name] == 1 and name not in self._in_texts

    def find(self, known: dict[str, "_Module"]) -> None:
        """Find the constants, those of the modules imported from first."""
        for node in self.tree.body:
            match node:
                case ast.ImportFrom():
                    source = known.get(self.source_of(node))
                    for alias in node.names:
                        name = alias.asname or alias.name
                        if source and alias.name in source.constants and self.may_be_constant(name):
                            self.constants[name] = source.constants[alias.name]
                case ast.Assign(targets=[ast.Name(id=name)], value=value) if self.may_be_constant(name):
                    number = self._number(value)
                    if number is not None:
                        self.constants[name] = number
                        self.definitions[name] = node

    def _number(self, node: ast.expr) -> Number | None:
        """The value of an expression of constants; what a board would round otherwise is left to the board."""
        match node:
            case ast.Constant(value=bool()):
                return None
            case ast.Constant(value=int() | float() as value):
                return value
            case ast.Name(id=name):
                return self.constants.get(name)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                value = self._number(operand)
                return None if value is None else -value
            case ast.BinOp(left=left, op=operator, right=right) if type(operator) in _OPERATORS:
                a, b = self._number(left), self._number(right)
                return _OPERATORS[type(operator)](a, b) if isinstance(a, int) and isinstance(b, int) else None
        return None

    def rewritten(self, needed: set[tuple[str, str]], known: dict[str, "_Module"]) -> str:
        """The text with constants put in; definitions stay that are `needed` (module, name) elsewhere."""
        edits = [_edit(node, f"({number!r})" if number < 0 else repr(number))
                 for node in ast.walk(self.tree)
                 if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)
                 for number in [self.constants.get(node.id)] if number is not None]
        gone = [node for name, node in self.definitions.items() if (self.name, name) not in needed]
        edits = [edit for edit in edits if not any(_lies_in(edit, node) for node in gone)]
        edits += [_edit(node, "") for node in (*gone, *self.types)]
        edits += [_edit(node, self._import_left(node)) for node in self.imports if self.source_of(node) in known]
        return _edited(self.text, edits)

    def _import_left(self, node: ast.ImportFrom) -> str:
        """An import statement without what is put in."""
        names = [alias for alias in node.names if (alias.asname or alias.name) not in self.constants]
        if not names:
            return ""
        left = ast.ImportFrom(node.module, names, node.level)
        return ast.unparse(left)


def put_constants_in(sources: dict[str, tuple[bool, str]]) -> dict[str, str]:
    """The texts of a package's modules, by full name, from (is it a package's own file, text).

    All modules must be given: a constant that none of them uses by name any more is gone.
    """
    modules = {name: _Module(name, is_package, text) for name, (is_package, text) in sources.items()}
    done: dict[str, _Module] = {}
    while len(done) < len(modules):
        ready = [module for module in modules.values() if module.name not in done and all(
            module.source_of(node) not in modules or module.source_of(node) in done for node in module.imports)]
        for module in ready or [module for module in modules.values() if module.name not in done]:
            module.find(done)
            done[module.name] = module
    needed = set(_needed(modules))
    return {name: module.rewritten(needed, modules) for name, module in modules.items()}


def _needed(modules: dict[str, _Module]) -> Iterator[tuple[str, str]]:
    """(module, name) of what is imported where it cannot be put in, or looked up in a module."""
    attributes = {node.attr for module in modules.values() for node in ast.walk(module.tree)
                  if isinstance(node, ast.Attribute)}
    for module in modules.values():
        yield from ((module.name, name) for name in module.definitions if name in attributes)
        for node in ast.walk(module.tree):
            if isinstance(node, ast.ImportFrom):
                put_in = node in module.imports
                yield from ((module.source_of(node), alias.name) for alias in node.names
                            if not put_in or (alias.asname or alias.name) not in module.constants)


def _bound_names(tree: ast.Module) -> Iterator[str]:
    """Every name that is bound anywhere, as often as it is."""
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name, ctx=ast.Store() | ast.Del()) | ast.arg(arg=name):
                yield name
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                yield name
            case ast.Import(names=names) | ast.ImportFrom(names=names):
                yield from (alias.asname or alias.name.partition(".")[0] for alias in names)
            case ast.Global(names=names) | ast.Nonlocal(names=names):
                yield from (name for name in names for _ in range(2))
            case ast.ExceptHandler(name=str() as name):
                yield name


def _edit(node: ast.stmt | ast.expr, text: str) -> _Edit:
    assert node.end_lineno is not None and node.end_col_offset is not None
    return _Edit((node.lineno, node.col_offset), (node.end_lineno, node.end_col_offset), text)


def _lies_in(edit: _Edit, node: ast.stmt) -> bool:
    whole = _edit(node, "")
    return whole.start <= edit.start and edit.end <= whole.end


def _edited(text: str, edits: list[_Edit]) -> str:
    """`text` with all edits made; each keeps the number of lines."""
    lines = [line.encode() for line in text.splitlines(keepends=True)]
    for (first, start), (last, end), new in sorted(edits, reverse=True):
        before, after = lines[first - 1][:start], lines[last - 1][end:]
        lines[first - 1 : last] = [before + new.encode() + b"\n" * (last - first) + after]
        lines[first:first] = [b""] * (last - first)
    return b"".join(lines).decode()
