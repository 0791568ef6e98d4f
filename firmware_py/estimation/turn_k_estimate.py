"""In-flight estimate of the turning-rate constant K, by recursive least squares with forgetting.

Over blocks of 0.25 s, the turning of the kite (less meridian convergence and gravity) is regressed on
the turning that TURN_K predicts from airspeed and steering: the slope is the ratio of the two constants, and
the offset a steady turning that is not due to steering.
"""

from math import pi, sin

from ..generated_enums import KITE_VALID_HEADING
from ..parameters.generated_parameters import AIRSPEED_MIN, GRAVITY_C, K_ADAPT, K_BOUND, TURN_K
from ..sphere import TWO_PI

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

    from .estimator import Estimator

_BLOCK = 0.25  # type: Final  # [s]
_LONGEST_GAP = 0.2  # type: Final  # between two samples, beyond which the turning between them is not known well [s]
_MEMORY = 48  # type: Final  # blocks
_PRIOR = 2  # type: Final  # blocks that the start counts for
_PRIOR_SPREAD = 4e-4  # type: Final  # variance of the expected turning in them [rad^2]
_LEAST_TURNING = 0.1  # type: Final  # that steering makes beyond its mean; a block with less teaches nothing [rad/s]
_MOST_TURNING = 2.0  # type: Final  # in a block; more is an error of the sensor [rad]


class TurnKEstimate:
    """`value` [rad/m] is the estimate, within bounds; `in_use` whether the control laws are to fly with it."""

    def __init__(self) -> None:
        self.value: float = 0.0
        self.in_use: bool = False
        self._turn_k: float = 0.0
        self._bound: float = 1.0
        self._gravity_c: float = 0.0
        self._airspeed_min: float = 1.0
        self._blocks: int = _PRIOR
        self._mean_expected: float = 0.0
        self._mean_turned: float = 0.0
        self._spread: float = _PRIOR_SPREAD
        self._together: float = _PRIOR_SPREAD  # covariance of expected and actual turning
        self._time: float = 0.0  # the block so far
        self._expected: float = 0.0
        self._turned: float = 0.0
        self._direction: float = 0.0  # at the last sample
        self._drive: float = 0.0
        self._usable: bool = False  # there is a last sample

    def load(self, values: list[float]) -> None:
        """Load the settings from the parameters' `values`; the estimate stays if TURN_K changes."""
        turn_k = values[TURN_K]
        if self._turn_k and turn_k != self._turn_k:
            scale = turn_k / self._turn_k
            self._mean_expected *= scale
            self._spread *= scale * scale
            self._together *= scale
            self._usable = False
        self._turn_k = turn_k
        self._bound = values[K_BOUND]
        self._gravity_c = values[GRAVITY_C]
        self._airspeed_min = values[AIRSPEED_MIN]
        self.in_use = values[K_ADAPT] > 0.0
        self._conclude()

    def take(self, kite: "Estimator", steering: float) -> None:
        """Use a new sample of the `kite`, an estimate, and the actual `steering` at its time."""
        dt = kite.interval
        drive = self._turn_k * kite.airspeed * steering
        direction = kite.heading if kite.valid & KITE_VALID_HEADING else kite.course
        if not self._usable or kite.coasting or not 0.0 < dt <= _LONGEST_GAP:
            self._begin_block()
        else:
            turned = (direction - self._direction + kite.meridian_turning) % TWO_PI
            if turned > pi:
                turned -= TWO_PI
            if self._gravity_c:
                gravity = self._gravity_c / max(kite.airspeed, self._airspeed_min)
                turned -= gravity * sin(kite.heading) * kite.frame.e1z * dt
            self._turned += turned
            self._expected += 0.5 * (drive + self._drive) * dt
            self._time += dt
        self._drive = drive
        self._direction = direction
        self._usable = not kite.coasting
        if self._time >= _BLOCK:
            self._learn()
            self._begin_block()

    def _begin_block(self) -> None:
        self._time = self._expected = self._turned = 0.0

    def _learn(self) -> None:
        """One step of the recursion, with the block that has come to its end."""
        scale = _BLOCK / self._time
        beyond = self._expected * scale - self._mean_expected
        turned = self._turned * scale - self._mean_turned
        if abs(beyond) < _LEAST_TURNING * _BLOCK:
            return
        if abs(self._turned) > _MOST_TURNING or abs(self._expected) > _MOST_TURNING * self._bound:
            return
        self._blocks = min(self._blocks + 1, _MEMORY)
        weight = 1.0 / self._blocks
        keep = 1.0 - weight
        self._mean_expected += weight * beyond
        self._mean_turned += weight * turned
        self._spread = keep * (self._spread + weight * beyond * beyond)
        self._together = keep * (self._together + weight * beyond * turned)
        self._conclude()

    def _conclude(self) -> None:
        factor = self._together / self._spread
        self.value = self._turn_k * max(1.0 / self._bound, min(self._bound, factor))
