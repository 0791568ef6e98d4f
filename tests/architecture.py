"""Draws docs/architecture.md's pictures from the imports: `make architecture`. Mermaid, which GitHub renders.

An arrow means "imports" when it runs, not for a type alone; one that a longer way implies is left out.
"""

import re
import sys
from pathlib import Path

import grimp

PAGE = Path(__file__).parent.parent / "docs" / "architecture.md"
HOUSE = ("firmware_py", "ground", "kite_analysis", "protocol", "sim_bridge")
Graph = dict[str, set[str]]


def rooms_of(package: str) -> Graph:
    """What each room of a package imports of the others: its sub-packages, and the modules beside them."""
    return _by_part(grimp.build_graph(package, cache_dir=None, exclude_type_checking_imports=True), 1)


def houses() -> Graph:
    """What each package imports of the others."""
    return _by_part(grimp.build_graph(*HOUSE, cache_dir=None, exclude_type_checking_imports=True), 0)


def _by_part(graph: grimp.ImportGraph, part: int) -> Graph:
    """The imports between modules, told by one part of their dotted names."""
    found: Graph = {}
    for module in graph.modules:
        for imported in graph.find_modules_directly_imported_by(module):
            names = [name.split(".")[part] for name in (module, imported) if name.count(".") >= part]
            if len(names) == 2:  # else one of them is the package itself
                ours, theirs = names
                found.setdefault(ours, set()).update({theirs} - {ours})
                found.setdefault(theirs, set())
    return found


def reduced(graph: Graph) -> Graph:
    """Without the arrows that a longer way implies (in a circle, all stay)."""
    reach = {name: _reach(graph, name) for name in graph}
    return {name: {other for other in others
                   if not any(other in reach[between] for between in others - {other} if name not in reach[between])}
            for name, others in graph.items()}


def _reach(graph: Graph, start: str) -> set[str]:
    seen, todo = set(), list(graph[start])
    while todo:
        name = todo.pop()
        if name not in seen:
            seen.add(name)
            todo += graph[name]
    return seen


def mermaid(graph: Graph) -> str:
    """The picture of a graph, the same text for the same imports."""
    lines = [f"    {name} --> {other}" for name, others in sorted(reduced(graph).items()) for other in sorted(others)]
    return "\n".join(["```mermaid", "flowchart TD", *lines, "```"])


def drawn(page: str) -> str:
    """`page` with the pictures between its marks drawn anew."""
    def picture(mark: re.Match[str]) -> str:
        name = mark[1]
        return f"<!-- imports: {name} -->\n{mermaid(houses() if name == 'house' else rooms_of(name))}\n<!-- end -->"
    return re.sub(r"<!-- imports: (\w+) -->\n.*?<!-- end -->", picture, page, flags=re.DOTALL)


def main() -> int:
    """Write the page; with --check only say whether that would change it."""
    before = PAGE.read_text("utf-8")
    after = drawn(before)
    if "--check" in sys.argv:
        return int(before != after)
    PAGE.write_text(after, "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
