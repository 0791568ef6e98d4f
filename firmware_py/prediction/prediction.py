"""Prediction of the kite's state over the dead time, to when the steering decided now will act.

The steering already sent turns the kite until then, through the actuator's limits, by the turning-rate law
(J. H. Baayen, 2012, equation 1) with gravity (M. Erhard and H. Strauch, 2013); a kite that does not turn flies a great
circle. The path consists of a few arcs. The rotation vector of each is that of constant rates plus the first term of
Magnus' series for a turning rate that changes: exact for constant steering, of fourth order else.
"""

from math import pi, sin

from ..clock import HALF, MASK
from ..generated_enums import KITE_VALID_STEERING
from ..parameters.generated_parameters import (
    AIRSPEED_MIN,
    COURSE_WINDOW,
    GRAVITY_C,
    LOOP_HZ,
    PRED_DELAY,
    PRED_RATE,
    STALE_TIME,
    STEER_MAX,
    TURN_OFFSET,
)
from ..sphere import TWO_PI, TangentFrame
from .body_rotation import BodyRotation
from .drift import Drift
from .steering_history import ONE, ROOM

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

    from ..estimation.estimator import Estimator
    from .steering_history import SteeringHistory

_ARCS = 4  # type: Final  # at most
_ARC_TURN = 0.9  # type: Final  # turning of a fully steered kite from which on another arc is worth its time [rad]
_SAMPLES = 256  # type: Final  # that the usual age is the mean of
_TAIL = 0.5  # type: Final  # of a tick: what is decided now is held for one tick, and stands for its middle
_LEAD_SHARE = 0.3  # type: Final  # of the time in which the actuator goes from straight to full steering
_MOST_STEERING = 2.0  # type: Final


class PredictionConfig:
    """Settings of the prediction, in SI units and microseconds where named so."""

    def __init__(self) -> None:
        self.delay_us: int = 0
        self.period_us: int = 20000
        self.stale_us: int = 0
        self.turn_offset: float = 0.0
        self.gravity_c: float = 0.0
        self.airspeed_min: float = 1.0
        self.rate_limit: float = 0.0
        self.smoothing: float = 0.0
        self.lead: float = 0.0  # how far a slow actuator has to look ahead on the curve [s]

    def load(self, values: list[float]) -> None:
        """Load the settings from the parameters' `values`."""
        self.delay_us = int(values[PRED_DELAY] * 1e6 + 0.5)
        self.period_us = int(1000000 / values[LOOP_HZ])
        self.stale_us = int(values[STALE_TIME] * 1e6)
        self.turn_offset = values[TURN_OFFSET]
        self.gravity_c = values[GRAVITY_C]
        self.airspeed_min = values[AIRSPEED_MIN]
        self.rate_limit = rate = values[PRED_RATE]
        self.lead = _LEAD_SHARE * values[STEER_MAX] / rate if rate else 0.0
        self.smoothing = 0.5 * values[COURSE_WINDOW]  # as late as the speed across the sphere is


class Prediction:
    """The predicted kite, with all that the control laws need from an estimate.

    `speed` is that across the unit sphere [1/s], `turning_ratio` the ratio of heading rate to course rate.
    `steered_turning` is the turning rate of the actual steering there [rad/s of the nose], `turning_slew` how fast the
    actuator can change it [rad/s^2], 0 for no limit.
    """

    def __init__(self, history: "SteeringHistory") -> None:
        self.config = PredictionConfig()
        self.frame = TangentFrame()
        self.course: float = 0.0
        self.heading: float = 0.0
        self.airspeed: float = 0.0  # smoothed: gusts would use up what the actuator can do
        self.speed: float = 0.0
        self.turning_ratio: float = 1.0
        self.steered_turning: float = 0.0
        self.turning_slew: float = 0.0
        self.horizon_us: int = 0  # from the sample to when the steering decided on now is first felt
        self._history = history
        self._rotation = BodyRotation()
        self._drift = Drift()
        self._usual_age: int = 0  # of a sample in the tick that takes it; the clocks need not agree [us]
        self._samples: int = 0
        self._followed: bool = False  # True while samples are smoothed

    def note_sample(self, kite: "Estimator", now: int) -> None:
        """The `kite`, an estimate, has taken a sample in the tick that was due at `now`."""
        config = self.config
        age = ((now - kite.sample_time + HALF) & MASK) - HALF
        late = age - self._usual_age
        samples = self._samples
        if not samples or late > config.stale_us or -late > config.stale_us:  # the first, or the sender's clock was set
            self._usual_age = age
            self._samples = 1
        else:
            if samples < _SAMPLES:
                samples = self._samples = samples + 1
            self._usual_age += (late + samples // 2) // samples
        if not config.delay_us:
            self._followed = False
            return
        if self._followed and kite.interval > 0.0:
            self.airspeed += (kite.airspeed - self.airspeed) * kite.interval / (kite.interval + config.smoothing)
        else:
            self.airspeed = kite.airspeed
            self._drift.forget()
        self._followed = True
        self._drift.observe(kite, self.airspeed)

    def steering_at_sample(self, kite: "Estimator", now: int) -> float:
        """Actual steering at the time of the newest sample: as measured, else as the actuator's model has it."""
        if kite.valid & KITE_VALID_STEERING:
            return kite.steering
        self._find_sample(kite, now)
        return self._history.position / ONE

    def update(self, kite: "Estimator", now: int, turn_k: float, late_us: int = 0) -> None:
        """Predict from the newest sample of the `kite`, an estimate, that turns by K = `turn_k` [rad/m].

        The tick was due at `now` and began `late_us` after it: the steering before it acts for so much longer, and that
        decided on now for so much less.
        """
        if not self._followed:  # just switched on, and no sample since
            self.note_sample(kite, now)
        partial, ticks = self._find_sample(kite, now)
        drift = self._drift
        drift.begin(kite)
        turned = self._fly(kite, partial, ticks, _TAIL + _TAIL * late_us / self.config.period_us, turn_k)
        frame = self.frame
        self.heading = self._rotation.carry(kite.frame, kite.heading, frame)
        course = (self.heading + drift.end(turned)) % TWO_PI
        self.course = course - TWO_PI if course > pi else course
        self.speed = drift.speed
        self.turning_ratio = drift.turning_ratio

    def _find_sample(self, kite: "Estimator", now: int) -> tuple[float, int]:
        """Take the actuator's model to the sample's time; return the fraction of a tick and the ticks sent since."""
        config = self.config
        period = config.period_us
        horizon = config.delay_us + ((now - kite.sample_time + HALF) & MASK) - HALF - self._usual_age
        if horizon < 0:
            horizon = 0
        elif horizon > (ROOM - 1) * period:
            horizon = (ROOM - 1) * period
        self.horizon_us = horizon
        ticks = -(-horizon // period)
        beyond = horizon - (ticks - 1) * period  # of the oldest of them, what lies after the sample
        partial = beyond / period if 0 < beyond < period else 0.0
        measured = None
        if kite.valid & KITE_VALID_STEERING:
            steering = kite.steering
            if steering > _MOST_STEERING:
                steering = _MOST_STEERING
            elif steering < -_MOST_STEERING:
                steering = -_MOST_STEERING
            measured = round(steering * ONE)
        self._history.begin(ticks, partial, measured)
        return partial, ticks - 1 if partial else ticks

    def _fly(self, kite: "Estimator", partial: float, ticks: int, tail: float, turn_k: float) -> float:
        """Rotate over the arcs from the sample on, with `tail` of a tick behind the last; return the turning [rad]."""
        config = self.config
        history = self._history
        rotation = self._rotation
        drift = self._drift
        period = config.period_us * 1e-6
        full = turn_k * self.airspeed  # turning rate of full steering
        unit = full * period / ONE
        unit_moment = unit * period
        arcs = 1 + int(unit * history.saturation * ticks / _ARC_TURN)
        if arcs > _ARCS:
            arcs = _ARCS
        if arcs > ticks:
            arcs = ticks or 1
        airspeed = self.airspeed
        if airspeed < config.airspeed_min:
            airspeed = config.airspeed_min
        gravity = config.gravity_c / airspeed * kite.frame.e1z if config.gravity_c else 0.0
        offset = config.turn_offset
        blown = drift.blown
        forward = drift.forward
        sideways = drift.sideways
        turned = 0.0
        rotation.begin()
        for left in range(arcs, 0, -1):
            whole = ticks // left
            ticks -= whole
            end = tail if left == 1 else 0.0
            history.advance(partial, whole, end)
            length = (partial + whole + end) * period
            partial = 0.0
            turn = unit * history.total
            if offset:
                turn += offset * length
            turn_moment = unit_moment * history.moment
            mean = turned + 0.5 * turn - turn_moment / length  # turned so far, over the arc
            if gravity:
                turn += gravity * length * sin(kite.heading + mean)
            if blown:
                drift.turn(mean)
                forward = drift.forward
                sideways = drift.sideways
            rotation.turn(turn, forward * turn_moment - sideways * length, forward * length + sideways * turn_moment)
            turned += turn
        full = turn_k * airspeed  # with the airspeed that is steered by
        self.steered_turning = full * history.position / ONE
        self.turning_slew = full * config.rate_limit
        return turned
