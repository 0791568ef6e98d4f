"""The commands and programs that README and docs show, collected from the Markdown itself."""

import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parent.parent.parent
PAGES = ("README.md", "CONTRIBUTING.md", *sorted(f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md")))
EXAMPLES = tuple(sorted(f"docs/examples/{path.name}" for path in (ROOT / "docs" / "examples").glob("*.py")))
_PROGRAMS = (r"(?:\.venv/bin/)?(?:kite-sitl|kite-ground|make|python|pip|mpremote|mavproxy\.py|mavlogdump\.py"
             r"|mavgen\.py|wireshark|tshark|eval)")
_FENCE = re.compile(r"^( *)```(\w*)\n(.*?)^ *```", re.MULTILINE | re.DOTALL)
_INLINE = re.compile(rf"`({_PROGRAMS} [^`]+)`", re.DOTALL)
_INDENTED = re.compile(rf"^ {{4,}}({_PROGRAMS} .+)$", re.MULTILINE)


class Shown(NamedTuple):
    """A command, or a program in Python, and where it is shown: `page:line`."""

    where: str
    text: str
    is_python: bool = False

    @property
    def calls_a_kite(self) -> bool:
        """Is it a program of a ground station?"""
        return self.is_python and "import ground" in self.text


def shown_on(page: str) -> list[Shown]:
    """What `page` (a path in the checkout) shows, in its order, each command once."""
    text = (ROOT / page).read_text("utf-8")
    found = []
    if page.endswith(".py"):
        found += [(match.start(), match[1], False) for match in _INDENTED.finditer(text)]
    else:
        for fence in _FENCE.finditer(text):
            found += _in_fence(fence)
        prose = _FENCE.sub(lambda fence: re.sub(r"[^\n]", " ", fence[0]), text)
        found += [(match.start(1), " ".join(match[1].split()), False) for match in _INLINE.finditer(prose)]
    unique = {}
    for at, shown, is_python in sorted(found):
        unique.setdefault(shown, Shown(f"{page}:{text.count(chr(10), 0, at) + 1}", shown, is_python))
    return list(unique.values())


def _in_fence(fence: re.Match[str]) -> list[tuple[int, str, bool]]:
    if fence[2] == "python":
        return [(fence.start(3), fence[3], True)]
    if fence[2] != "sh":
        return []
    found, at = [], fence.start(3)
    for line in fence[3].splitlines(keepends=True):
        command = re.sub(r"(^|\s+)#\s.*$", "", line.strip())
        if command:
            found.append((at, command, False))
        at += len(line)
    return found
