"""The turning-rate constant found in flight: what it learns from, what it does not, and its bounds."""

import math
import random

import pytest
from eights import parameters
from firmware_bench import EVERYTHING, HEADING

from firmware_py.estimation.estimator import Estimator
from firmware_py.estimation.turn_k_estimate import TurnKEstimate

PERIOD_S = 0.02
AIRSPEED = 20.0


class Flown:
    """An estimate, and a kite of constant `turn_k` [rad/m] that it watches."""

    def __init__(self, turn_k: float, offset: float = 0.0, noise: float = 0.0, valid: int = EVERYTHING, **changed):
        self.estimate = TurnKEstimate()
        self.estimate.load(parameters(TURN_K=0.25, **changed))
        self.turn_k, self.offset, self.noise = turn_k, offset, noise
        self.kite = Estimator()
        self.kite.airspeed, self.kite.valid, self.kite.interval = AIRSPEED, valid, PERIOD_S
        self.angle = 0.0
        self.time_s = 0.0
        self._random = random.Random(1)

    def fly(self, seconds: float, size: float, mean: float = 0.0) -> float:
        """Steer with a sine of `size` about `mean`; return what is found over what is true."""
        for _ in range(round(seconds / PERIOD_S)):
            steering = mean + size * math.sin(1.6 * self.time_s)
            self.angle += 0.5 * PERIOD_S * self._rate(steering)
            self.time_s += PERIOD_S
            steering = mean + size * math.sin(1.6 * self.time_s)
            self.angle += 0.5 * PERIOD_S * self._rate(steering)
            seen = math.remainder(self.angle + self._random.gauss(0.0, self.noise), 2.0 * math.pi)
            self.kite.course = self.kite.heading = seen
            self.estimate.take(self.kite, steering)
        return self.estimate.value / self.turn_k

    def _rate(self, steering: float) -> float:
        return self.turn_k * AIRSPEED * steering + self.offset


@pytest.mark.parametrize("turn_k", [0.125, 0.2, 0.25, 0.375, 0.5])
def test_it_is_found_within_a_few_eights(turn_k):
    assert Flown(turn_k).fly(30.0, 0.3) == pytest.approx(1.0, abs=0.01)
    assert Flown(turn_k, offset=0.3).fly(30.0, 0.3) == pytest.approx(1.0, abs=0.01)
    assert Flown(turn_k, noise=0.05).fly(30.0, 0.3) == pytest.approx(1.0, abs=0.05)


def test_a_course_alone_will_do():
    flown = Flown(0.4, valid=EVERYTHING & ~HEADING)
    flown.kite.heading = 3.0
    assert flown.fly(20.0, 0.3) == pytest.approx(1.0, abs=0.02)


def test_straight_flight_teaches_nothing():
    """Neither noise nor an offset moves it, for as long as it lasts; and what was known stays known."""
    flown = Flown(0.35, offset=0.5, noise=0.05)
    assert flown.fly(600.0, 0.0) * 0.35 == pytest.approx(0.25)
    before = flown.fly(40.0, 0.3)
    assert before == pytest.approx(1.0, abs=0.05)
    assert flown.fly(600.0, 0.01) == pytest.approx(before, abs=0.02)


def test_it_follows_a_kite_that_changes():
    flown = Flown(0.3)
    flown.fly(60.0, 0.3)
    flown.turn_k = 0.2
    assert flown.fly(60.0, 0.3) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize(("bound", "low", "high"), [(1.0, 0.25, 0.25), (2.0, 0.125, 0.5), (8.0, 0.03125, 2.0)])
def test_it_stays_within_its_bounds(bound, low, high):
    """Also where steering turns the kite the wrong way round, and where a sensor jumps about."""
    for turn_k in (-1.0, 0.0, 0.01, 3.0):
        flown = Flown(turn_k or 1e-9, K_BOUND=bound)
        for _ in range(40):
            flown.fly(0.5, 0.3)
            assert low <= flown.estimate.value <= high
    flown = Flown(0.25, noise=2.0, K_BOUND=bound)
    for airspeed in (0.0, 1e6, 20.0, 3e3):
        flown.kite.airspeed = airspeed
        flown.fly(20.0, 0.9)
        assert low <= flown.estimate.value <= high


def test_gaps_and_standing_still_are_left_out():
    flown = Flown(0.4)
    flown.fly(20.0, 0.3)
    known = flown.estimate.value
    for interval, coasting in ((0.0, False), (0.5, False), (PERIOD_S, True)):
        flown.kite.interval, flown.kite.coasting = interval, coasting
        flown.turn_k = 0.1
        flown.fly(10.0, 0.3)
        assert flown.estimate.value == known


def test_a_new_turn_k_in_flight_keeps_what_was_learnt():
    flown = Flown(0.4, K_BOUND=4.0)
    flown.fly(30.0, 0.3)
    known = flown.estimate.value
    for turn_k in (0.5, 0.125, 0.25):
        flown.estimate.load(parameters(TURN_K=turn_k, K_BOUND=4.0))
        assert flown.estimate.value == pytest.approx(known, rel=1e-9)
    assert flown.fly(5.0, 0.3) == pytest.approx(1.0, abs=0.02)
