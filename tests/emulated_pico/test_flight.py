"""A Pico flies, instruction by instruction: whether its ticks fit, with everything on that small-kite uses."""

import math

from sim_bridge.scenario.scenario import load_scenario
from tests.emulated_pico.flight import fly


def test_four_seconds_of_small_kite_with_prediction_at_the_default_rate(flying_pico):
    scenario = load_scenario("small-kite")
    scenario.set_text("run.duration_s=4", "--set")
    result, kept = fly(flying_pico, scenario)
    print(kept)
    assert kept.clock_mhz == 200.0  # the default of the board
    assert kept.ticks >= 198
    assert kept.lost == 0
    assert kept.latest <= 12.0
    assert kept.median <= 12.0
    assert kept.in_ticks == 0 and kept.collections > 20
    assert kept.longest_collection < 10.0  # twice as long where the marking overflows (firmware_py/garbage.py)
    cross_track, _ = result.flight.recent_errors(2.0)
    assert math.degrees(cross_track) < 0.1
