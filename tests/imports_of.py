"""What a program has imported by its end, seen from within its process."""

import subprocess
import sys
from typing import NamedTuple

HEAVY = {"numpy", "scipy", "matplotlib", "numba", "tqdm"}
_SCRIPT = """\
import sys
from {module} import main
try:
    code = main(sys.argv[1:])
except SystemExit as leaving:
    code = leaving.code
print(*sorted(sys.modules), file=sys.stderr)
sys.exit(code)
"""


class Ended(NamedTuple):
    """A program that has ended: what it printed, and the modules that it had imported."""

    code: int
    said: str
    modules: set[str]


def imports_of(program: str, *arguments: str) -> Ended:
    """Run `program`, the module of its `main`, with `arguments`."""
    return imports_of_script(_SCRIPT.format(module=program), *arguments)


def imports_of_script(script: str, *arguments: str) -> Ended:
    """Run a `script` whose last line on stderr is the modules."""
    done = subprocess.run([sys.executable, "-c", script, *arguments], capture_output=True, text=True, check=False)
    return Ended(done.returncode, done.stdout, set(done.stderr.splitlines()[-1].split()))
