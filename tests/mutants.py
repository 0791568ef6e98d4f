"""What `make mutants` ends with: how many mutants the tests killed, and whether docs/mutants.md lists those that live.

Reads what mutmut left in mutants/; exit code 1 where fewer than 90 % died, or a function has another number of
survivors than the page says.
"""

import json
import re
import sys
from collections import Counter
from pathlib import Path

LEAST_KILLED = 0.9
SURVIVED, NOT_TESTED = 0, 33  # mutmut's exit codes; any other of a mutant that ran is a death, or a timeout
PAGE = Path("docs/mutants.md")
ROW = re.compile(r"\| `([\w.]+)` \| (\d+) \|")


def survivors_on_page(text: str) -> dict[str, int]:
    """Number of survivors by function, as the table of docs/mutants.md lists them."""
    return {name: int(count) for name, count in ROW.findall(text)}


def function_of(mutant: str) -> str:
    """`inbox.Queue.put` of `firmware_py.services.inbox.xǁQueueǁput__mutmut_3`, as docs/mutants.md has it."""
    path, _, rest = mutant.partition(".x")
    module = path.rpartition(".")[2]
    return f"{module}.{rest.rpartition('__mutmut_')[0][1:].replace('ǁ', '.')}"


def results(folder: Path) -> tuple[Counter[str], Counter[str]]:
    """(mutants that ran, survivors) by function."""
    ran: Counter[str] = Counter()
    survived: Counter[str] = Counter()
    for file in sorted(folder.rglob("*.meta")):
        for mutant, code in json.loads(file.read_text())["exit_code_by_key"].items():
            if code is None:
                continue
            ran[function_of(mutant)] += 1
            survived[function_of(mutant)] += code in (SURVIVED, NOT_TESTED)
    return ran, +survived


def main() -> int:
    """Print the share by module and the survivors by function; return the exit code."""
    ran, survived = results(Path("mutants/firmware_py"))
    if not ran:
        print("no mutants were run: make mutants")
        return 1
    for module in sorted({name.partition(".")[0] for name in ran}):
        count, alive = (sum(number for name, number in table.items() if name.startswith(module + "."))
                        for table in (ran, survived))
        print(f"{module:20} {count:5} mutants, {100.0 * (count - alive) / count:5.1f} % killed")
    killed = 1.0 - survived.total() / ran.total()
    print(f"{'all':20} {ran.total():5} mutants, {100.0 * killed:5.1f} % killed")
    listed = survivors_on_page(PAGE.read_text("utf-8"))
    wrong = [name for name in sorted(set(listed) | set(survived)) if listed.get(name, 0) != survived[name]]
    for name in wrong:
        print(f"{name}: {survived[name]} survive, {PAGE} says {listed.get(name, 0)}; see: mutmut results")
    return int(killed < LEAST_KILLED or bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
