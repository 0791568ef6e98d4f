"""The gains that are flown with: those of the parameters, or gains scheduled from airspeed and line length.

J. H. Baayen, "Trajectory tracking control of kites with system delay" (2012), proposition 4.1, fixes P tau'; with time
counted in tau' and ways in line lengths R, the outer loop's gain enters the whole loop as L v tau' / R alone.
"""

from ..parameters.generated_parameters import (
    AIRSPEED_MIN,
    GAIN_L_TAU,
    GAIN_P_TAU,
    GAIN_TAU,
    INNER_P,
    LOOP_HZ,
    OUTER_L,
    TURN_K,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

    from ..estimation.estimator import Estimator
    from ..estimation.turn_k_estimate import TurnKEstimate

_SMOOTHING = 2.0  # type: Final  # gusts are not to be seen in the gains [s]
_MOST = 50.0  # type: Final  # of either gain, as of the parameters INNER_P and OUTER_L


class Gains:
    """`gain_p` [1/s], `gain_l`, and the turning-rate constant `turn_k` [rad/m] that the laws divide by."""

    def __init__(self) -> None:
        self.gain_p: float = 0.0
        self.gain_l: float = 0.0
        self.turn_k: float = 1.0
        self._scheduled: bool = False  # the gains follow the flight
        self._active: bool = False  # they are to, from the next sample on
        self._delay: float = 0.0  # tau' [s]
        self._p_tau: float = 0.0
        self._l_tau: float = 0.0
        self._airspeed_min: float = 1.0
        self._speed: float = 0.0  # v / R, smoothed [1/s]

    def load(self, values: list[float], estimate: "TurnKEstimate") -> None:
        """Load the settings from the parameters' `values`; K from `estimate` (a TurnKEstimate) if that is in use."""
        self._active = values[GAIN_TAU] > 0.0
        self._scheduled = self._scheduled and self._active
        self._delay = values[GAIN_TAU] + 0.5 / values[LOOP_HZ]
        self._p_tau = values[GAIN_P_TAU]
        self._l_tau = values[GAIN_L_TAU]
        self._airspeed_min = values[AIRSPEED_MIN]
        if not self._scheduled:
            self.gain_p = values[INNER_P]
            self.gain_l = values[OUTER_L]
        self.turn_k = estimate.value if estimate.in_use else values[TURN_K]

    def update(self, kite: "Estimator", estimate: "TurnKEstimate") -> None:
        """Follow a new sample of the `kite` (an Estimator) and the `estimate` of K."""
        if estimate.in_use:
            self.turn_k = estimate.value
        if not self._active:
            return
        speed = max(kite.airspeed, self._airspeed_min) / kite.distance
        if self._scheduled and kite.interval > 0.0:
            self._speed += (speed - self._speed) * kite.interval / (kite.interval + _SMOOTHING)
        else:
            self._speed = speed
        self._scheduled = True
        self.gain_p = min(_MOST, self._p_tau / self._delay)
        self.gain_l = min(_MOST, self._l_tau / (self._speed * self._delay))
