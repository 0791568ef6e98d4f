"""kite-sitl imports nothing heavy before it is used, and nothing that flies before a verb runs.

What flies may be compiled or not, and which is chosen before the first of it is imported: by `kite-sitl` when the
options have been read, by a sweep's worker when it gets its first run.
"""

import json

import pytest

from kite_analysis.console.verbs import function_called
from sim_bridge.cli.main import build_parser
from sim_bridge.cli.verbs import VERBS
from tests.imports_of import HEAVY, imports_of, imports_of_script

PROGRAM = "sim_bridge.cli.main"
FLIES = ("firmware_py", *(f"sim_bridge.{room}" for room in (
    "equipment", "flight", "links", "plants", "runtimes", "wind", "runs.run", "scenario.scenario")))
LINES = [
    "list", "keys --json", "run paper-delay --duration 1", "hil --link serial:/dev/x:115200 small-kite", "rerun folder",
    "paper --plant one-point", "shadow flight.csv", "bench", "sweep small-kite --over run.seed=1,2",
    "validate a.csv b.csv",
    "design --delay 0.2 --speed-over-length 0.45", "identify folder", "board-image folder", "flash /dev/x",
]


@pytest.mark.parametrize("verb", ["list", "keys"])
def test_listings_and_help_need_no_flight(verb):
    help_ = imports_of(PROGRAM, "--help")
    assert help_.code == 0 and "board-image" in help_.said and not help_.modules & {*HEAVY, "protocol", *FLIES}
    listed = imports_of(PROGRAM, verb, "--json")
    assert listed.code == 0 and len(json.loads(listed.said)) > 10
    assert not listed.modules & {*HEAVY, "protocol.dialect", "firmware_py", "sim_bridge.flight", "sim_bridge.runtimes"}


def test_nothing_that_flies_is_imported_before_a_verb_runs():
    assert {line.split()[0] for line in LINES} == {verb.name for verb in VERBS}
    script = ("import sys\nfrom sim_bridge.cli.main import build_parser\n"
              "for line in sys.argv[1:]:\n    build_parser().parse_args(line.split())\n"
              "print(*sys.modules, file=sys.stderr)")
    parsed = imports_of_script(script, *LINES)
    assert parsed.code == 0 and "sim_bridge.cli.options.sweep" in parsed.modules
    assert not parsed.modules & {*HEAVY, "protocol.dialect", *FLIES}


def test_a_sweeps_worker_imports_what_flies_at_its_first_run():
    script = "import sys, {}; print(*sys.modules, file=sys.stderr)"
    for module in ("sim_bridge.sweeps.worker", "sim_bridge.sweeps.execute"):
        imported = imports_of_script(script.format(module))
        assert imported.code == 0 and module in imported.modules
        assert not imported.modules & {*HEAVY, "protocol.dialect", *FLIES}


def test_all_that_the_table_of_verbs_names_is_there():
    for verb in VERBS:
        assert callable(function_called(verb.options)) and callable(function_called(verb.run)), verb
    build_parser().prepare_all()
