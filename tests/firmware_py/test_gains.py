"""Gains that follow airspeed and line length, when they are asked to."""

import pytest
from eights import gains
from firmware_bench import Bench, FlyingKite

from firmware_py.control.gains import Gains
from firmware_py.estimation.estimator import Estimator
from firmware_py.estimation.turn_k_estimate import TurnKEstimate
from protocol import dialect

NO_ESTIMATE = TurnKEstimate()


def flying(airspeed: float, length: float, interval: float = 0.0) -> Estimator:
    """A kite of `airspeed` [m/s] on a line of `length` [m], its sample `interval` [s] after the last."""
    kite = Estimator()
    kite.airspeed, kite.distance, kite.interval = airspeed, length, interval
    return kite


def schedule(airspeed: float, length: float, **changed: float) -> Gains:
    """The gains for a kite that has only just been seen."""
    made = gains(**{"GAIN_TAU": 0.24, "GAIN_P_TAU": 0.375, "GAIN_L_TAU": 0.25, **changed})
    made.update(flying(airspeed, length), NO_ESTIMATE)
    return made


def test_the_dimensionless_gains_are_what_stays():
    for loop_hz, tau in ((50.0, 0.25), (10.0, 0.29), (200.0, 0.2425)):
        for airspeed, length in ((20.0, 100.0), (10.0, 100.0), (20.0, 300.0)):
            scheduled = schedule(airspeed, length, LOOP_HZ=loop_hz)
            assert scheduled.gain_p * tau == pytest.approx(0.375)
            assert scheduled.gain_l * airspeed / length * tau == pytest.approx(0.25)


def test_gusts_are_not_in_the_gains_and_a_longer_line_is():
    scheduled = schedule(20.0, 100.0)
    calm = scheduled.gain_l
    for _ in range(10):
        scheduled.update(flying(26.0, 100.0, 0.02), NO_ESTIMATE)
    assert 0.97 * calm < scheduled.gain_l < calm
    for _ in range(1000):
        scheduled.update(flying(20.0, 200.0, 0.02), NO_ESTIMATE)
    assert scheduled.gain_l == pytest.approx(2.0 * calm, rel=1e-3)


def test_they_stay_within_the_gains_own_bounds():
    for airspeed in (0.0, 0.5, 1e6):
        for length in (1e-3, 1.0, 2000.0, 1e6):
            for tau in (1e-6, 5.0):
                scheduled = schedule(airspeed, length, GAIN_TAU=tau, GAIN_P_TAU=2.0, GAIN_L_TAU=2.0, LOOP_HZ=200.0)
                assert 0.0 <= scheduled.gain_p <= 50.0 and 0.0 <= scheduled.gain_l <= 50.0


def test_in_flight_it_takes_the_plain_gains_place_and_gives_it_back():
    bench = Bench(FlyingKite())
    bench.start(dialect.KITE_MODE_TRACK)
    bench.set(INNER_P=3.0, OUTER_L=4.0, GAIN_P_TAU=0.25, GAIN_L_TAU=0.125)
    flown = bench.autopilot.gains
    bench.run(0.1)
    assert (flown.gain_p, flown.gain_l) == (3.0, 4.0)
    bench.set(GAIN_TAU=0.115234375)  # 0.125 with half a period
    bench.run(0.1)
    assert flown.gain_p == pytest.approx(0.25 / 0.125, rel=2e-3)
    assert flown.gain_l == pytest.approx(0.125 / (0.2 * 0.125), rel=2e-3)  # 20 m/s on 100 m
    bench.set(GAIN_TAU=0.0)
    bench.run(0.1)
    assert (flown.gain_p, flown.gain_l) == (3.0, 4.0)
