"""README's first session, in simulated time: what a reader sees is what it says."""

import math
import re
from pathlib import Path

README = (Path(__file__).parent.parent.parent / "README.md").read_text("utf-8")


def errors(kite) -> tuple[float, float]:
    """Cross-track and turning angle [deg], RMS of 10 s, as the status line of `make sitl` has them."""
    cross_track, turning = kite.flight.recent_errors(10.0)
    return math.degrees(cross_track), math.degrees(turning)


def promised(command: str, pattern: str) -> float:
    """The number that README gives behind a command."""
    line = next(line for line in README.splitlines() if line.startswith(command))
    found = re.search(pattern, line)
    assert found, line
    return float(found[1])


def test_a_gain_that_is_too_much_is_seen_to_be_and_what_helps_helps(flying_kite, operator_of):
    kite = flying_kite("paper-delay-tuned")
    operator = operator_of(kite)
    kite.sleep(20.0)
    operator.runs("param", "set", "INNER_P", "8")
    kite.sleep(promised("kite-ground param set INNER_P 8", r"within (\d+) s"))
    assert errors(kite)[1] > 60.0
    kite.sleep(60.0)
    assert errors(kite)[0] > 6.0
    operator.runs("param", "set", "INNER_P", "1.84")
    kite.sleep(30.0 + 10.0)
    off = promised("kite-ground param set INNER_P 1.84", r"with (\d+) deg")
    assert abs(errors(kite)[0] - off) < 0.5
    operator.runs("param", "set", "FF_GAIN", "1")
    kite.sleep(30.0)
    assert abs(errors(kite)[0] - promised("kite-ground param set FF_GAIN 1", r"([\d.]+) deg")) < 0.15


def test_a_larger_gain_follows_the_eight_closer_until_it_is_unstable(flying_kite):
    said = re.search(r"([\d.]+) deg at 1.84, ([\d.]+) deg at 6; above ([\d.]+) it is\s+unstable", README)
    assert said
    for gain, off in ((1.84, float(said[1])), (6.0, float(said[2]))):
        kite = flying_kite("paper-delay-tuned", INNER_P=gain)
        kite.sleep(60.0)
        assert abs(errors(kite)[0] - off) < 0.4
    for factor, stable in ((0.97, True), (1.06, False)):
        kite = flying_kite("paper-delay-tuned", INNER_P=factor * float(said[3]))
        kite.sleep(90.0)
        assert (errors(kite)[1] < 20.0) is stable
