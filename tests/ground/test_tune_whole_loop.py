"""What `kite-ground tune` says about inner and outer loop together."""

import json
import subprocess
import sys

import pytest

from ground.errors import UsageError
from ground.tuning.gain_advice import speed_over_length
from ground.vehicle.state import VehicleState
from protocol import dialect


def test_the_whole_loop_is_shown_and_guards_what_is_written(operator):
    """A gain for the delay alone is refused where the outer loop makes it unstable, and taken once L is lower."""
    tune = ("tune", "--delay", "0.4", "--speed-over-length", "0.45")
    assert operator.runs(*tune, "--json") == 0
    advice = json.loads(operator.said)
    assert advice["whole_loop"]["limit"] == pytest.approx(0.4574, abs=1e-3)
    assert advice["whole_loop"]["best"]["outer_l"] == pytest.approx(0.602, abs=1e-3)
    assert advice["verdict"] == "UNSTABLE: above the limit together with OUTER_L" and not advice["stable"]
    operator.is_told(UsageError, "unstable with OUTER_L = 5 .* lower OUTER_L first .0.602", *tune, "--yes")
    assert operator.kite.firmware_parameter("INNER_P") == 1.5
    assert operator.runs("param", "set", "OUTER_L", "1") == 0
    assert operator.runs(*tune, "--yes") == 0
    for words in ("whole loop, 0.45 line lengths a second", "limit of P at the present L = 1", "best pair", "margins",
                  "1.079", "acknowledged by the kite"):
        assert words in operator.said
    operator.is_told(UsageError, "quarter of a circle", "tune", "--delay", "0.4", "--speed-over-length", "5")


def test_a_kite_at_rest_has_no_whole_loop(operator):
    assert operator.runs("tune", "--delay", "0.2", "--json") == 0
    assert json.loads(operator.said)["whole_loop"] is None
    operator.runs("tune", "--delay", "0.2", "--yes")
    assert "whole loop" not in operator.said and "--speed-over-length" in operator.remarked


def test_the_speed_is_the_newest_telemetrys():
    """13 m/s on a line of 50 m; a kite that stands, or has told nothing, has none."""
    state = VehicleState()
    assert speed_over_length(state) is None
    for velocity, expected in (((3.0, -4.0, 12.0), 0.26), ((0.0, 0.0, 0.01), None)):
        message = dialect.MAVLink_local_position_ned_message(1000, 30.0, 0.0, -40.0, *velocity)
        state.observe(0.0, message, b"")
        assert speed_over_length(state) == (None if expected is None else pytest.approx(expected))


def test_nothing_of_it_needs_scipy():
    """Neither at the start nor for the whole loop's numbers."""
    script = ("import sys; sys.modules['scipy'] = None\n"
              "import ground.cli.main\n"
              "from ground.tuning.gain_advice import advise, describe, with_outer_loop\n"
              "print('\\n'.join(describe(with_outer_loop(advise(0.2, 50.0, 1.75), 0.45, 3.0))))")
    said = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    assert "best pair" in said and "1.839" in said
