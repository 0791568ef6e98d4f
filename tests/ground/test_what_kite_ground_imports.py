"""kite-ground starts at once: nothing is imported before it is used."""

import os
import socket
import statistics
import subprocess
import sys
from importlib import import_module

import pytest

import ground
from ground.cli.main import build_parser
from ground.cli.verbs import VERBS
from kite_analysis.console.verbs import Verb, function_called
from tests.imports_of import HEAVY, imports_of, imports_of_script

PROGRAM = "ground.cli.main"
PAIRS = 9


def test_help_needs_no_verb_and_a_verbs_help_only_its_own():
    help_ = imports_of(PROGRAM, "--help")
    assert help_.code == 0 and "savechanged" not in help_.said and "completion" in help_.said
    assert not help_.modules & {*HEAVY, "protocol", "pymavlink", "serial", "ground.kite", "ground.session"}
    group = imports_of(PROGRAM, "param", "--help")
    assert group.code == 0 and "savechanged" in group.said and "protocol" not in group.modules
    mode = imports_of(PROGRAM, "mode", "--help")
    verbs = {name for verb in VERBS for name in modules_of(verb)}
    assert mode.code == 0 and "kite-ground mode track" in mode.said
    assert mode.modules & verbs == {"ground.cli.vehicle", "ground.cli.options"}


def modules_of(verb: Verb) -> set[str]:
    """The modules that a verb names, and those that the verbs in it name."""
    own = {name.partition(":")[0] for name in (verb.options, verb.run) if name}
    return own.union(*map(modules_of, verb.verbs))


def test_help_takes_at_most_twice_as_long_as_its_three_modules_of_the_standard_library():
    """Processor time, in turns, so that what else the machine does slows both down."""
    ours, least = [], []
    for _ in range(PAIRS + 1):  # the first is for the disk
        ours.append(processor_s("from ground.cli.main import main; main(['--help'])"))
        least.append(processor_s("import argparse, socket, json"))
    assert statistics.median(ours[1:]) < 2.0 * statistics.median(least[1:])


def processor_s(script: str) -> float:
    """Processor time that Python takes for `script` [s]."""
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0
    return used.ru_utime + used.ru_stime


@pytest.fixture
def kite():
    """The link to a simulated kite in the air."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as plain:
        plain.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{plain.getsockname()[1]}"
    command = [sys.executable, "-m", "sim_bridge.cli.main", "run", "paper-delay-tuned", "--runtime", "cpython",
               "--speed", "1", "--ground", "--forever", "--set", f"ground.send_to={address}",
               "--set", "ground.listen=127.0.0.1:0"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as flying:
        yield f"udpin:{address}"
        flying.terminate()


def test_a_parameter_is_read_from_a_kite_without_numpy(kite):
    got = imports_of(PROGRAM, "--link", kite, "--timeout", "60", "param", "get", "INNER_P", "--json")
    assert got.code == 0 and '"name": "INNER_P"' in got.said
    assert "protocol.dialect" in got.modules and not got.modules & HEAVY


def test_the_api_is_imported_when_it_is_used():
    alone = imports_of_script("import sys, ground; assert 'Kite' in dir(ground); print(*sys.modules, file=sys.stderr)")
    assert alone.code == 0 and "ground.errors" in alone.modules
    assert not alone.modules & {*HEAVY, "ground.kite", "protocol"}
    api = import_module("ground.kite")
    assert ground.Kite is api.Kite and ground.connect is api.connect
    with pytest.raises(AttributeError, match="no attribute 'Kites'"):
        ground.Kites  # noqa: B018  # pyright: ignore[reportAttributeAccessIssue]


def test_all_that_the_table_of_verbs_names_is_there():
    def look_at(verb: Verb) -> None:
        assert verb.verbs or verb.run, verb
        assert all(callable(function_called(name)) for name in (verb.options, verb.run) if name), verb
        for other in verb.verbs:
            look_at(other)

    for verb in VERBS:
        look_at(verb)
    build_parser().prepare_all()
