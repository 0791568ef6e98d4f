"""Designs of thousands of loops, each told its own best pair at full precision, where three roots are one."""

import json
import subprocess
import sys

import numpy as np
import pytest

from kite_analysis.delay.characteristic_equation import Loop
from kite_analysis.delay.whole_loop import best_gains, design

pytestmark = pytest.mark.soak


def some_loops(count: int) -> list[tuple[float, float]]:
    """(tau [s], speed over length [1/s]); others each time, said by pytest where one fails."""
    return [(float(tau_s), float(w)) for tau_s, w in np.random.default_rng().uniform((0.02, 0.01), 1.0, (count, 2))]


def test_two_thousand_designs_are_answered_for_their_own_best_pairs():
    for tau_s, w in some_loops(2000):
        loop = Loop(tau_s + 0.01, w)
        gains, best = best_gains(loop)
        told = design(loop, gains)
        assert told.rate == pytest.approx(best, rel=1e-4), (loop, gains)
        assert told.margins.gain > 1.0, (loop, gains)


def test_the_command_is_told_the_pair_that_it_gave():
    for tau_s, w in some_loops(50):
        arguments = ["--delay", repr(tau_s), "--speed-over-length", repr(w)]
        best = designed(arguments)["whole_loop"]["best"]
        told = designed([*arguments, "--gain-p", repr(best["inner_p"]), "--gain-l", repr(best["outer_l"])])
        assert told["whole_loop"]["present"]["rate"] == pytest.approx(best["rate"], rel=1e-4), arguments


def designed(arguments: list[str]) -> dict:
    done = subprocess.run([sys.executable, "-m", "sim_bridge.cli.main", "design", "--json", *arguments],
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0 and not done.stderr, (arguments, done.stderr)
    return json.loads(done.stdout)
