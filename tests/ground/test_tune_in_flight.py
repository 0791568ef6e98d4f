"""Tuning a kite that flies: the delay that is measured is the one it flies with, and a step shows what it does."""

import json

import pytest

from ground.errors import UsageError
from ground.kite import connect_over
from protocol.single_precision import float32


@pytest.mark.parametrize(("delay_s", "ground_loss", "within_s"), [(0.2, 0.0, 0.002), (0.13, 0.0, 0.002),
                                                                  (0.3, 0.0, 0.002), (0.2, 0.2, 0.01)])
def test_the_delay_in_the_loop_is_found_from_the_flight(flying_kite, delay_s, ground_loss, within_s):
    """Half of it on the way down, in whole periods: the samples tell that; the rest shows in how the kite turns."""
    flying = flying_kite("paper-delay", f"link.control.delay_s={delay_s}", loss=ground_loss, round_trip_s=0.8,
                         INNER_P=1.2)
    with connect_over(flying.links(), background=False) as kite:
        kite.wait(5.0)
        report = kite.measure_delay(25.0)
    assert report.loop.whole_s == pytest.approx(delay_s, abs=within_s)
    assert report.loop.sample_age_s == pytest.approx(int(delay_s / 2 * 50) / 50, abs=1e-6)
    assert report.loop.fit > 0.99
    assert report.round_trip and report.round_trip.median_s == pytest.approx(0.82, abs=0.03)
    assert report.round_trip.loss == pytest.approx(1.0 - (1.0 - ground_loss) ** 2, abs=0.15)


def test_the_dead_time_of_the_actuator_is_in_it(flying_kite):
    """small-kite: 0.15 s of links, 0.05 s of dead time, and a rate limit of 4 1/s that it knows of."""
    with connect_over(flying_kite("small-kite").links(), background=False) as kite:
        assert kite.measure_delay(30.0).loop.whole_s == pytest.approx(0.2, abs=0.012)


def test_tune_measures_shows_and_steps(flying_kite, operator_of):
    """P = 1 is too slow for a delay of 0.2 s: half as much again tracks better, and stays."""
    operator = operator_of(flying_kite("paper-delay", INNER_P=1.0))
    assert operator.runs("tune", "--step", "+50%", "--yes") == 0
    for words in ("sample age at the tick             0.100 s", "steering link, actuator, kite      0.100 s",
                  "total, steering to turn            0.200 s", "ground link, round trip",
                  "0 [------P----o------", "INNER_P                            1       1.5",
                  "INNER_P = 1.5 1/s, acknowledged by the kite\n"):
        assert words in operator.said
    assert operator.kite.firmware_parameter("INNER_P") == 1.5
    assert operator.runs("tune", "--step", "-40 %", "--yes", "--json") == 0
    advice = json.loads(operator.said)
    assert advice["written"] is False and advice["measured"]["whole_s"] == pytest.approx(0.2, abs=0.002)
    before, after = advice["step"]["before"], advice["step"]["after"]
    assert after["turning_rad"] > 1.1 * before["turning_rad"] and before["seconds"] >= 10.0
    assert operator.kite.firmware_parameter("INNER_P") == 1.5
    assert operator.runs("param", "revert", "--yes") == 0
    assert operator.kite.firmware_parameter("INNER_P") == 1.0


def test_a_step_towards_the_limit_is_refused_and_one_that_runs_away_is_taken_back(flying_kite, operator_of):
    """The operator states too short a delay; the kite diverges, and has its old gain back before the end."""
    operator = operator_of(flying_kite("paper-delay", INNER_P=5.0))
    operator.is_told(UsageError, "not set: INNER_P = 10 would be unstable: the limit is 6.7", "tune", "--delay", "0.2",
                     "--step", "+100%", "--yes")
    assert operator.runs("tune", "--delay", "0.02", "--step", "+100%", "--yes", "--duration", "30") == 0
    assert "the flight diverged: INNER_P = 5 restored, acknowledged by the kite" in operator.said
    assert operator.kite.firmware_parameter("INNER_P") == float32(5.0)


def test_a_kite_that_does_not_fly_tells_no_delay(operator):
    operator.is_told(UsageError, r"no loop delay found in \d+ states in STANDBY: steering explains only 0% .*"
                     " --delay S", "tune", "--yes")
    operator.is_told(UsageError, "a step is measured in TRACK, and the kite is in STANDBY: run kite-ground mode track",
                     "tune", "--delay", "0.2", "--step", "+10%", "--yes")
    assert operator.kite.firmware_parameter("INNER_P") == 1.5


def test_an_actuator_that_slews_all_the_time_does_not_hide_the_dead_time(flying_kite):
    """v3-flight: the law asks for far more than 0.21 1/s gives; its limits are known, and 0.48 s are found."""
    with connect_over(flying_kite("v3-flight").links(), background=False) as kite:
        for _ in range(3):
            loop = kite.measure_delay(20.0).loop
            assert loop.whole_s == pytest.approx(0.48, abs=0.06) and loop.fit > 0.98
