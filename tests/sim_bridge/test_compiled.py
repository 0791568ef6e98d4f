"""Machine code on disk: importing touches nothing, the first call compiles, the next process reuses what it kept."""

import os
import subprocess
import sys
from importlib.util import find_spec

import pytest

pytestmark = pytest.mark.skipif(find_spec("numba") is None, reason="numba is not installed")

IMPORT = """
from numba.core import config
before = config.CACHE_DIR
import sim_bridge.compiled
from sim_bridge.plants import four_point, one_point, particles, tether
from sim_bridge.plants.vortex_lattice import plant
assert config.CACHE_DIR == before, config.CACHE_DIR
"""
CALL = IMPORT + """
from sim_bridge.scenario.scenario import load_scenario
from sim_bridge.flight.plant_choice import warm_up
warm_up(load_scenario("small-kite-one-point"), print)
assert config.CACHE_DIR == before, config.CACHE_DIR
functions = [value for value in vars(one_point).values() if hasattr(value, "stats")]
print(sum(sum(function.stats.cache_hits.values()) for function in functions),
      sum(sum(function.stats.cache_misses.values()) for function in functions))
"""


@pytest.fixture
def kept(tmp_path):
    """A folder for machine code that holds some of an older kitepilot's, and a file of somebody else's."""
    old = tmp_path / "compiled-0123456789abcdef"
    old.mkdir()
    (old / "machine.nbc").write_text("old")
    (tmp_path / "theirs").write_text("not ours")
    return tmp_path


def python(code, kept):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(kept), "NUMBA_DISABLE_JIT": "0"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_importing_leaves_disk_and_numba_as_they_are(kept):
    python(IMPORT, kept)
    assert sorted(path.name for path in kept.iterdir()) == ["compiled-0123456789abcdef", "theirs"]
    assert (kept / "compiled-0123456789abcdef" / "machine.nbc").read_text() == "old"


def test_the_first_call_keeps_its_code_removes_the_old_and_the_next_process_compiles_nothing(kept):
    _, misses = map(int, python(CALL, kept).split()[-2:])
    assert misses > 0
    ours, theirs = sorted(path.name for path in kept.iterdir())
    assert ours.startswith("compiled-") and ours != "compiled-0123456789abcdef" and theirs == "theirs"
    hits, misses = map(int, python(CALL, kept).split()[-2:])
    assert hits > 0 and misses == 0
