"""The gains P and L from dimensionless ones, as airspeed and line length change.

J. H. Baayen, "Trajectory tracking control of kites with system delay" (2012), proposition 4.1, fixes P tau'; with time
counted in tau' and ways in line lengths R, the outer loop's gain enters the whole loop as L v tau' / R alone.
"""

from ..parameters.generated_parameters import AIRSPEED_MIN, GAIN_L_TAU, GAIN_P_TAU, GAIN_TAU, LOOP_HZ

_SMOOTHING = 2.0  # gusts are not to be seen in the gains [s]
_MOST = 50.0  # of either gain, as of the parameters INNER_P and OUTER_L


class GainSchedule:
    """`gain_p` [1/s] and `gain_l`, while they are `known`."""

    def __init__(self):
        self.known = False
        self._active = False
        self.gain_p = 0.0
        self.gain_l = 0.0
        self._delay = 0.0  # tau' [s]
        self._p_tau = 0.0
        self._l_tau = 0.0
        self._airspeed_min = 1.0
        self._speed = 0.0  # v / R, smoothed [1/s]

    def load(self, values):
        """Take the parameters over from their `values`."""
        self._active = values[GAIN_TAU] > 0.0
        self.known = self.known and self._active
        self._delay = values[GAIN_TAU] + 0.5 / values[LOOP_HZ]
        self._p_tau = values[GAIN_P_TAU]
        self._l_tau = values[GAIN_L_TAU]
        self._airspeed_min = values[AIRSPEED_MIN]

    def update(self, kite):
        """Follow a new sample of the `kite`, an estimate."""
        if not self._active:
            return
        speed = max(kite.airspeed, self._airspeed_min) / kite.distance
        if self.known and kite.interval > 0.0:
            self._speed += (speed - self._speed) * kite.interval / (kite.interval + _SMOOTHING)
        else:
            self._speed = speed
        self.known = True
        self.gain_p = min(_MOST, self._p_tau / self._delay)
        self.gain_l = min(_MOST, self._l_tau / (self._speed * self._delay))
