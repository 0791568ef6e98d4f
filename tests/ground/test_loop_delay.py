"""The delay in the loop where the firmware keeps its own time: samples come twice, late, and on another clock."""

import numpy as np
import pytest

from ground.tuning.loop_delay import measure_loop_delay
from kite_analysis.flights.record import as_recorded
from protocol import dialect
from protocol.clock import WRAP_US, ages_s


@pytest.mark.parametrize("apart_s", [0.0, 300.0, 535.0, -400.0])
@pytest.mark.parametrize("seed", [1, 2])
def test_ticks_that_beat_with_the_samples_tell_the_delay_as_well(apart_s, seed):
    """A kite at the horizon, K Va = 20 1/s, 0.2 s from asking to turning. Its samples, every 20 ms, are 30 ms on the
    way, and the ticks come when they come: now and then one sees a sample again, or stands still for a while."""
    random = np.random.default_rng(seed)
    fine_s = np.arange(-5.0, 40.0, 0.001)
    steering = 0.02 * np.sin(1.3 * fine_s) + 0.03 * np.sin(2.9 * fine_s)
    course = np.cumsum(20.0 * np.interp(fine_s - 0.17, fine_s, steering)) * 0.001
    tick_s = np.cumsum(random.choice([0.012, 0.02, 0.028, 0.2], 1200, p=[0.3, 0.39, 0.3, 0.01]))
    tick_s = tick_s[tick_s < 30.0]
    sampled_s = np.floor((tick_s - 0.03) / 0.02) * 0.02
    ticks_us, samples_us = (np.round(time_s * 1e6) % WRAP_US for time_s in (tick_s, sampled_s - apart_s))
    count = len(tick_s)
    columns = {
        "course": np.interp(sampled_s, fine_s, course), "heading": np.interp(sampled_s, fine_s, course),
        "azimuth": np.zeros(count), "elevation": np.zeros(count), "airspeed": np.full(count, 20.0),
        "set_steering": np.interp(tick_s, fine_s, steering), "sample_age_s": np.array(ages_s(ticks_us, samples_us))}
    valid = np.full(count, float(dialect.KITE_VALID_HEADING))
    loop = measure_loop_delay(as_recorded(tick_s, columns, further={"valid": valid}))
    assert loop.fit > 0.99
    usual_s = float(np.median(tick_s - sampled_s))
    assert loop.whole_s == pytest.approx(0.17 + usual_s, abs=0.015)
    assert (loop.sample_age_s is None) == (apart_s != 0.0)
