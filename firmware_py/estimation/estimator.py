"""From sensor samples to the kite's state: which samples are accepted, and the source of the turning angle."""

from math import atan2, pi, radians, sin, sqrt

from ..clock import HALF, MASK, ticks_diff
from ..generated_enums import (
    KITE_VALID_AIRSPEED,
    KITE_VALID_AZIMUTH,
    KITE_VALID_COURSE,
    KITE_VALID_DISTANCE,
    KITE_VALID_ELEVATION,
    KITE_VALID_HEADING,
    KITE_VALID_STEERING,
    KITE_VALID_TETHER_FORCE,
)
from ..parameters.generated_parameters import (
    AIRSPEED_NOM,
    COURSE_SOURCE,
    COURSE_WINDOW,
    JUMP_RATE,
    LINE_LENGTH,
    SPEED_MIN,
    STALE_TIME,
)
from ..sphere import TWO_PI, TangentFrame, wrap

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

    from ..sample import Sample

_POSITION = KITE_VALID_AZIMUTH | KITE_VALID_ELEVATION  # type: Final
_HISTORY = 32  # type: Final
_INDEX = _HISTORY - 1  # type: Final
_FROM_COURSE = 1.0  # type: Final
_FROM_POSITIONS = 2.0  # type: Final
_FROM_HEADING = 3.0  # type: Final
_LEAST_DISTANCE = 1.0  # type: Final  # [m]
_MOST_DISTANCE = 10000.0  # type: Final
_MOST_AIRSPEED = 200.0  # type: Final  # [m/s]
# A stamp further ahead than this is an error of the sensor's clock, not a link that catches up.
_AHEAD_US = 5000000  # type: Final
_FOREVER_US = 1 << 29  # type: Final  # ages count no further
_STANDING = 1e-6  # type: Final  # a chord no longer than this is rounding, and has no direction [rad]
_SLACK = 0.003  # type: Final  # a jump of this size is sensor noise, however short the time [rad]


class EstimatorConfig:
    """Settings of the estimator, in SI units and radians."""

    def __init__(self) -> None:
        self.airspeed_nominal: float = 0.0
        self.course_source: float = 0.0
        self.course_window: float = 0.0
        self.window_us: int = 0  # the same
        self.jump_rate: float = 0.0
        self.line_length: float = 0.0
        self.speed_min: float = 0.0
        self.stale_us: int = 0

    def load(self, values: list[float]) -> None:
        """Load the settings from the parameters' `values`."""
        self.airspeed_nominal = values[AIRSPEED_NOM]
        self.course_source = values[COURSE_SOURCE]
        self.course_window = values[COURSE_WINDOW]
        self.window_us = int(values[COURSE_WINDOW] * 1e6)
        self.jump_rate = radians(values[JUMP_RATE])
        self.line_length = values[LINE_LENGTH]
        self.speed_min = values[SPEED_MIN]
        self.stale_us = int(values[STALE_TIME] * 1e6)


class Estimator:
    """The estimated state of the kite. `frame` is its position with the tangent plane."""

    def __init__(self) -> None:
        self.config = EstimatorConfig()
        self.frame = TangentFrame()
        self.azimuth: float = 0.0
        self.elevation: float = 0.0
        self.distance: float = 0.0
        self.course: float = 0.0
        self.heading: float = 0.0
        self.airspeed: float = 0.0
        self.tether_force: float = 0.0
        self.steering: float = 0.0
        self.speed: float = 0.0  # across the sphere [m/s]
        self.turning_ratio: float = 1.0  # nose and course are taken to turn alike, by an actuator as fast as need be:
        self.turning_slew: float = 0.0  # see Prediction
        self.steered_turning: float = 0.0
        self.valid: int = 0
        self.sample_time: int = 0
        self.interval: float = 0.0  # between the last two samples taken [s]
        self.coasting: bool = False
        self.dropped: int = 0
        self._heard: bool = False
        self._stale: bool = True
        self._age_us: int = 0  # since a sample was accepted
        self._looked_time: int = 0  # the sample before this one, accepted or not
        self._looked_azimuth: float = 0.0
        self._looked_elevation: float = 0.0
        self._looked_age_us: int = _FOREVER_US
        self._times: list[int] = [0] * _HISTORY  # of past positions, and these: rings
        self._xs: list[float] = [0.0] * _HISTORY
        self._ys: list[float] = [0.0] * _HISTORY
        self._zs: list[float] = [0.0] * _HISTORY
        self._count: int = 0
        self._oldest: int = 0  # the position that the chord starts from
        self._chord: float = 0.0
        self._span: float = 0.0
        self._turning: float = 0.0  # smoothed rate of the chord's direction, without meridian convergence [rad/s]
        self.meridian_turning: float = 0.0  # since the sample before: added to a change of course or heading [rad]

    def has_heard(self) -> bool:
        """True once a sample was accepted."""
        return self._heard

    def is_stale(self) -> bool:
        """True if no accepted sample is fresh enough to steer by."""
        return self._stale

    def wait(self, elapsed_us: int) -> bool:
        """Let `elapsed_us` pass, before new samples are taken; return True if samples are then stale.

        Ages are accumulated instead of computed from times: the clock may wrap, or jump.
        """
        age_us = self._age_us + elapsed_us
        self._age_us = age_us if age_us < _FOREVER_US else _FOREVER_US
        looked_us = self._looked_age_us + elapsed_us
        self._looked_age_us = looked_us if looked_us < _FOREVER_US else _FOREVER_US
        if self._age_us > self.config.stale_us:
            self._stale = True
        return self._stale

    def take(self, sample: "Sample", asked: float, turn_k: float) -> bool:
        """Use `sample` (values of KITE_SENSORS), which has just arrived.

        The steering last `asked` for stands in where the sample has no actual one; `turn_k` [rad/m] turns the course of
        a kite that is too slow for its course to be measured. Returns True if the sample was accepted, False if it was
        dropped, and counts that.
        """
        fresh_start = self._stale
        time_us, azimuth, elevation, _, course, _, _, _, _, _ = sample
        span_us = ((time_us - self.sample_time + HALF) & MASK) - HALF
        if not self._is_sane(sample) or not self._brings_news(time_us, span_us, azimuth, elevation, fresh_start):
            self.dropped += 1
            return False
        if fresh_start:
            self._count = self._oldest = 0
            self._turning = 0.0
        self._heard = True
        self._stale = False
        self._age_us = 0
        self.sample_time = time_us
        self.interval = 0.0 if fresh_start else span_us * 1e-6
        self._copy(sample, asked)
        self._update_course(course, fresh_start, turn_k)
        return True

    def sphere_speed(self) -> float:
        """Speed across the unit sphere [1/s], with the arc in the chord's place."""
        speed = self.speed / self.distance
        bend = self._turning * self._span
        reach = speed * self._span
        longer = bend * bend / 24.0 + reach * reach / 6.0
        return speed * (1.0 + (longer if longer < 1.0 else 1.0))

    def _is_sane(self, sample: "Sample") -> bool:
        """False for a sample without position, not finite, or out of range."""
        _, azimuth, elevation, line, course, heading, airspeed, tether_force, steering, valid = sample
        if valid & _POSITION != _POSITION or not -3.2 <= azimuth <= 3.2 or not -1.5708 <= elevation <= 1.5708:
            return False
        if valid & KITE_VALID_COURSE and not -1e6 < course < 1e6:  # also refuses NaN
            return False
        if valid & KITE_VALID_HEADING and not -1e6 < heading < 1e6:
            return False
        if valid & KITE_VALID_TETHER_FORCE and not -1e6 < tether_force < 1e6:
            return False
        if valid & KITE_VALID_STEERING and not -1e6 < steering < 1e6:
            return False
        if valid & KITE_VALID_DISTANCE and not _LEAST_DISTANCE <= line <= _MOST_DISTANCE:
            return False
        return not valid & KITE_VALID_AIRSPEED or 0.0 <= airspeed <= _MOST_AIRSPEED

    def _brings_news(self, time_us: int, span_us: int, azimuth: float, elevation: float, fresh_start: bool) -> bool:
        """True for a sample `span_us` later than the one accepted last, from where the kite can have come.

        It is held against the sample before it even where that was refused, so that jumps are not accepted one by one,
        each as soon as there was time enough for it.
        """
        news = True
        if fresh_start or ((self._looked_time - self.sample_time + HALF) & MASK) > HALF:
            if self._looked_age_us <= self.config.stale_us:
                news = self._is_way(
                    ticks_diff(time_us, self._looked_time), self._looked_age_us,
                    self._looked_azimuth, self._looked_elevation, azimuth, elevation,
                )
            else:
                news = time_us != self._looked_time or not self._heard
        self._looked_time = time_us
        self._looked_azimuth = azimuth
        self._looked_elevation = elevation
        self._looked_age_us = 0
        if fresh_start or not news:
            return news
        return self._is_way(span_us, self._age_us, self.azimuth, self.elevation, azimuth, elevation)

    def _is_way(
        self, span_us: int, age_us: int, azimuth: float, elevation: float, to_azimuth: float, to_elevation: float
    ) -> bool:
        """True if the kite can have flown from one place to the other in `span_us`, by the sensor's clock.

        `age_us` is the same span by the firmware's clock: less, where a link catches up with what it held back.
        """
        if not 0 < span_us <= age_us + _AHEAD_US:
            return False
        most = self.config.jump_rate * span_us * 1e-6 + _SLACK
        aside = to_azimuth - azimuth
        above = to_elevation - elevation
        if (aside if aside > 0.0 else -aside) + (above if above > 0.0 else -above) <= most:  # no distance is longer
            return True
        return distance(azimuth, elevation, to_azimuth, to_elevation) <= most

    def _copy(self, sample: "Sample", asked: float) -> None:
        """Take over the quantities that are valid; stand in for the others."""
        config = self.config
        _, azimuth, elevation, line, _, heading, airspeed, tether_force, steering, valid = sample
        self.valid = valid
        azimuth_step = (azimuth - self.azimuth) % TWO_PI
        if azimuth_step > pi:
            azimuth_step -= TWO_PI
        self.azimuth = azimuth
        self.elevation = elevation
        self.distance = line if valid & KITE_VALID_DISTANCE else config.line_length
        self.airspeed = airspeed if valid & KITE_VALID_AIRSPEED else config.airspeed_nominal
        self.tether_force = tether_force if valid & KITE_VALID_TETHER_FORCE else 0.0
        self.steering = steering if valid & KITE_VALID_STEERING else asked
        self.frame.set(azimuth, elevation)
        self.meridian_turning = self.frame.z * azimuth_step
        if valid & KITE_VALID_HEADING:
            self.heading = heading

    def _update_course(self, measured: float, fresh_start: bool, turn_k: float) -> None:
        """Turning angle from the source that the parameter names and the sample has."""
        self._measure_chord()
        valid = self.valid
        source = self.config.course_source
        if source == 0.0:
            source = _FROM_COURSE if valid & KITE_VALID_COURSE else _FROM_POSITIONS
        if source == _FROM_HEADING and valid & KITE_VALID_HEADING:
            self.coasting = False
            self.course = self.heading
            return
        coasting = self.coasting = self.speed < self.config.speed_min and not fresh_start
        if source == _FROM_COURSE and valid & KITE_VALID_COURSE and not coasting:
            self.course = measured
        elif coasting:
            rate = turn_k * self.airspeed * self.steering
            self.course = wrap(self.course + rate * self.interval)
        elif self._count > 1:
            self.course = wrap(self._chord + 0.5 * self._span * self._turning)
        if not valid & KITE_VALID_HEADING:
            self.heading = self.course

    def _measure_chord(self) -> None:
        """Remember the position; direction and length of the way from one of some time ago to it.

        The geodesic's direction where it ends; on a turn it lags by half the time between the two, which
        `_turning` makes good.
        """
        frame = self.frame
        sample_time = self.sample_time
        newest = self._count
        index = newest & _INDEX
        times = self._times
        times[index] = sample_time
        self._xs[index] = frame.x
        self._ys[index] = frame.y
        self._zs[index] = frame.z
        self._count = newest + 1
        if newest < 1:
            self._span = 0.0
            return
        config = self.config
        oldest = self._oldest
        if oldest < newest - _INDEX:
            oldest = newest - _INDEX
        while oldest < newest - 1:  # leave behind what the window does not need
            if (sample_time - times[(oldest + 1) & _INDEX]) & MASK < config.window_us:
                break
            oldest += 1
        self._oldest = oldest
        index = oldest & _INDEX
        span = ((sample_time - times[index]) & MASK) * 1e-6
        x = self._xs[index]
        y = self._ys[index]
        up = frame.e1x * x + frame.e1y * y + frame.e1z * self._zs[index]
        across = frame.e2x * x + frame.e2y * y
        length = sqrt(up * up + across * across)
        self.speed = length * self.distance / span
        if length > _STANDING:
            chord = atan2(-across, -up)
            if newest > 1:
                interval = self.interval
                turned = (chord - self._chord + self.meridian_turning) % TWO_PI
                rate = (turned - TWO_PI if turned > pi else turned) / interval
                self._turning += (rate - self._turning) * interval / (interval + config.course_window)
            self._chord = chord
        self._span = span


def distance(azimuth: float, elevation: float, to_azimuth: float, to_elevation: float) -> float:
    """Great-circle distance [rad] between two places (haversine, exact for small angles in float32)."""
    vertical = sin(0.5 * (to_elevation - elevation))
    horizontal = sin(0.5 * (to_azimuth - azimuth))
    half = vertical * vertical + sin(0.5 * pi - to_elevation) * sin(0.5 * pi - elevation) * horizontal * horizontal
    return 2.0 * atan2(sqrt(half), sqrt(max(0.0, 1.0 - half)))
