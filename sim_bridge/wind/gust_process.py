"""Gusts as random processes in time: sums of Dryden's, discretised exactly.

With T = length / speed, a Dryden gust is white noise through sqrt(2 T) / (1 + T s) along the wind, and through
sqrt(T) (1 + sqrt(3) T s) / (1 + T s)^2 across it. Whatever the period, the values at its multiples are distributed as
those of the process in continuous time, and they start in its stationary distribution.
"""

from collections.abc import Sequence
from math import exp, sqrt
from random import Random
from typing import Final

Parts = Sequence[tuple[float, float]]  # of each: share of the variance, time constant over the period

_SQRT3: Final = sqrt(3.0)


class LongitudinalGust:
    """`value` has mean 0 and variance 1; each part is a first-order Gauss-Markov process."""

    def __init__(self, parts: Parts, random: Random):
        self._random = random
        self._steps = []
        self._states = []
        for share, time in parts:
            keep = exp(-1.0 / time)
            self._steps.append((sqrt(share), keep, sqrt(1.0 - keep * keep)))
            self._states.append(random.gauss())
        self.value = 0.0
        self.advance()

    def advance(self) -> None:
        """Move on by one period."""
        gauss, states, value = self._random.gauss, self._states, 0.0
        for i, (size, keep, spread) in enumerate(self._steps):
            states[i] = state = keep * states[i] + spread * gauss()
            value += size * state
        self.value = value


class TransverseGust:
    """As LongitudinalGust, for across and upwards.

    The state of a part is a = sqrt(2) / (1 + T s) times the noise and b = a / (1 + T s), of stationary covariance
    [[1, 1/2], [1/2, 1/2]]; the gust is (sqrt(3) a + (1 - sqrt(3)) b) / sqrt(2).
    """

    def __init__(self, parts: Parts, random: Random):
        self._random = random
        self._steps = []
        self._states = []
        for share, time in parts:
            self._steps.append((sqrt(0.5 * share), *_transverse_step(1.0 / time)))
            first, second = random.gauss(), random.gauss()
            self._states.append((first, 0.5 * first + 0.5 * second))
        self.value = 0.0
        self.advance()

    def advance(self) -> None:
        """Move on by one period."""
        gauss, states, value = self._random.gauss, self._states, 0.0
        for i, (size, keep, pass_on, spread, common, own) in enumerate(self._steps):
            a, b = states[i]
            noise = gauss()
            b = keep * b + pass_on * a + common * noise + own * gauss()
            a = keep * a + spread * noise
            states[i] = a, b
            value += size * (_SQRT3 * a + (1.0 - _SQRT3) * b)
        self.value = value


def _transverse_step(theta: float) -> tuple[float, float, float, float, float]:
    """(e, theta e) of the transition [[e, 0], [theta e, e]] over theta time constants, and a root of the noise's
    covariance P - F P F^T, [[spread, 0], [common, own]]."""
    keep = exp(-theta)
    square = keep * keep
    spread = sqrt(1.0 - square)
    common = (0.5 - square * (0.5 + theta)) / spread
    own = sqrt(max(0.0, 0.5 - square * (0.5 + theta + theta * theta) - common * common))
    return keep, theta * keep, spread, common, own
