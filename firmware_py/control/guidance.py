"""Outer loop: the nearest point of the target curve, and the direction that leads onto it.

J. H. Baayen, "Trajectory tracking control of kites with system delay" (2012), section 2.2.
"""

from math import atan, atan2, cos, pi, sin, sqrt

from ..parameters.generated_parameters import FF_FILTER
from ..sphere import TWO_PI, wrap
from .figure_eight import CurvePoint

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

    from ..prediction.prediction import Prediction
    from ..sphere import TangentFrame
    from .figure_eight import FigureEight
    from .gains import Gains

_ITERATIONS = 5  # type: Final
_CLOSE_ENOUGH = 1e-4  # type: Final  # step in s at which the search ends [rad]
_CLOSE_EACH_TICK = 3e-4  # type: Final  # the same, where each tick goes on with it
_LONGEST_STEP = 0.2  # type: Final  # in s [rad], short enough not to reach another strand
_SCAN_POINTS = 32  # type: Final
_SCAN_STEP = 2.0 * pi / _SCAN_POINTS  # type: Final
_LEAST_SHARE = 0.2  # type: Final  # of the distance to a turn's centre that a kite inside it keeps
_FURTHEST_AHEAD = 0.8  # type: Final  # in s [rad]: beyond lies another bend
_CURVE_SHARE = 0.5  # type: Final  # of the actuator's rate for the curve; the rest is for errors
_LOOK_EVERY = 4  # type: Final  # ticks: what is ahead changes slowly, and a look takes a board a millisecond
_COURSE_WEIGHT = 0.2  # type: Final  # of flying the right way beside being near, when a strand is picked anew


class GuidanceConfig:
    """Settings of the outer loop: `filter_time` [s] of the target's rate."""

    def __init__(self) -> None:
        self.filter_time: float = 0.0

    def load(self, values: list[float]) -> None:
        """Load the settings from the parameters' `values`."""
        self.filter_time = values[FF_FILTER]


class Guidance:
    """State of the outer loop; angles in radians, `cross_track` positive when the curve lies on the side gamma x T."""

    def __init__(self, curve: "FigureEight") -> None:
        self.curve = curve
        self.config = GuidanceConfig()
        self.path_parameter: float = 0.0
        self.target_course: float = 0.0
        self.target_rate: float = 0.0  # [rad/s]
        self.cross_track: float = 0.0
        self.running: bool = False  # True while a strand is followed
        self._point = CurvePoint(curve)  # the nearest
        self._ahead = CurvePoint(curve)  # where it will be nearest after the lead
        self._look_in: int = 0  # ticks until it is looked ahead again
        self._beyond: float = 0.0  # curvature that is begun early [rad/rad]
        self._along: float = 0.0  # the curve's own direction, carried to the kite [rad]
        self._side: float = 0.0  # t . gamma_t
        self._cosine: float = 1.0  # of the distance
        self._exact: bool = False  # True when the target's rate is not from its change
        self._pace: float = 0.0  # in s, from one tick to the next [rad]
        self._close: float = _CLOSE_ENOUGH
        self._scan_index: int = 0
        self._scan_best: float = -9.0
        self._scan_best_s: float = 0.0
        self._candidate: float | None = None

    def stop(self) -> None:
        """Forget the strand: the next step picks the best one anew."""
        self.running = False
        self.target_rate = 0.0
        self._pace = 0.0
        self._look_in = 0

    def scan(self, frame: "TangentFrame", course: float) -> None:
        """Look at one more point of the whole curve, so that a far kite finds its way without a costly search."""
        if self._exact and self.running and abs(self.cross_track) < self.curve.half_height:
            self._scan_index = 0  # on its strand, and each tick has enough to do
            self._scan_best = -9.0
            self._candidate = None
            return
        s = self._scan_index * _SCAN_STEP
        x, y, z, dx, dy, dz = self.curve.at(s)
        along = cos(course) * frame.up(dx, dy, dz) + sin(course) * frame.across(dx, dy)
        along *= self.curve.direction / sqrt(dx * dx + dy * dy + dz * dz)
        score = frame.x * x + frame.y * y + frame.z * z + _COURSE_WEIGHT * along
        if score > self._scan_best:
            self._scan_best = score
            self._scan_best_s = s
        self._scan_index += 1
        if self._scan_index == _SCAN_POINTS:
            self._candidate = self._scan_best_s
            self._scan_index = 0
            self._scan_best = -9.0

    def step(self, frame: "TangentFrame", gains: "Gains", dt: float) -> None:
        """Update the target for the kite at `frame`, `dt` [s] after the step before, with the `gains`."""
        same = self.running
        self._close = _CLOSE_ENOUGH
        before = self.target_course
        self._find(frame)
        self._aim(frame, gains.gain_l)
        if not (same and self.running) or dt <= 0.0:
            self.target_rate = 0.0
        elif not self._exact:  # else the step before was at another place, and its rate holds
            rate = wrap(self.target_course - before) / dt
            self.target_rate += (rate - self.target_rate) * dt / (dt + self.config.filter_time)
        self._exact = False
        self._pace = 0.0
        self.running = True

    def step_exactly(self, kite: "Prediction", gains: "Gains") -> None:
        """Update the target for a predicted `kite`, each tick; the target's rate is then no difference."""
        before = self.path_parameter
        self.path_parameter = before + self._pace  # so near that the search has little to do
        self._close = _CLOSE_EACH_TICK
        same = self.running
        if same and self._candidate is None:
            self._go_to_nearest(kite.frame)
        else:
            self._find(kite.frame)
        self._pace = wrap(self.path_parameter - before) if same and self.running else 0.0
        self._aim(kite.frame, gains.gain_l)
        self.running = True
        self.target_rate = self._turning(kite, gains.gain_l)
        self._exact = True

    def _turning(self, kite: "Prediction", gain: float) -> float:
        """Turning rate [rad/s], beyond the meridians', that keeps the turning-angle error as it is.

        With the curve `-side` to the left of the kite's, chi the course against it and v the speed: the curve's
        parallel through the kite turns by v cos(chi) (kappa cos - side) / (cos + kappa side), and the aim at it by
        -L v sin(chi) cos / (1 + L^2 side^2), where kappa is the curve's geodesic curvature, early where
        the actuator is too slow for it.
        """
        side = self._side
        cosine = self._cosine
        curvature = self.curve.direction * self._point.geodesic_curvature()
        lead = kite.config.lead
        if lead:
            self._look_in -= 1
            if self._look_in <= 0:
                self._look_in = _LOOK_EVERY
                self._beyond = self._beyond_actuator(kite, curvature, lead)
            curvature += self._beyond
        chi = kite.course - self._along
        slope = gain * side
        share = cosine + curvature * side
        parallel = (curvature * cosine - side) / (share if share > _LEAST_SHARE else _LEAST_SHARE)
        return kite.speed * (cos(chi) * parallel - sin(chi) * gain * cosine / (1.0 + slope * slope))

    def _beyond_actuator(self, kite: "Prediction", curvature: float, lead: float) -> float:
        """Change of the curvature within `lead` [s], less what the actuator makes of it with a share of its rate."""
        way = kite.speed * lead / self._point.pace
        if way > _FURTHEST_AHEAD:
            way = _FURTHEST_AHEAD
        ahead = self._ahead
        ahead.go_to(self.path_parameter + self.curve.direction * way)
        change = self.curve.direction * ahead.geodesic_curvature() - curvature
        needed = kite.turning_ratio * kite.speed * change  # of the nose's turning rate
        possible = _CURVE_SHARE * kite.turning_slew * lead
        if needed > possible:
            return change * (needed - possible) / needed
        if needed < -possible:
            return change * (needed + possible) / needed
        return 0.0

    def _find(self, frame: "TangentFrame") -> None:
        """Go to the nearest point, on the strand that is followed or a better one; `running` tells whether the same."""
        if not self.running and self._candidate is not None:
            self.path_parameter = self._candidate
        self._go_to_nearest(frame)
        candidate = self._candidate
        if candidate is not None and self._is_lost(frame, candidate):
            self.running = False
            self.path_parameter = candidate
            self._go_to_nearest(frame)

    def _go_to_nearest(self, frame: "TangentFrame") -> None:
        """Ascend the cosine of the distance from the last solution.

        The first step is Gauss-Newton's, the next ones take the curvature from the change of the slope and stay
        within twice Gauss-Newton's and within _LONGEST_STEP, so that the search stays on its strand.
        """
        point = self._point
        x = frame.x
        y = frame.y
        z = frame.z
        s = self.path_parameter
        step = last_slope = 0.0
        for iteration in range(_ITERATIONS):
            point.go_to(s)
            slope = x * point.dx + y * point.dy + z * point.dz
            size = slope if slope > 0.0 else -slope
            longest = size / point.square
            if iteration and step:
                curvature = (last_slope - slope) / step
                if curvature > 0.0:
                    longest = min(2.0 * longest, size / curvature)
            if longest > _LONGEST_STEP:
                longest = _LONGEST_STEP
            step = longest if slope > 0.0 else -longest
            last_slope = slope
            s += step
            if longest < self._close:
                break
        else:
            point.go_to(s)
        self.path_parameter = s % (2.0 * pi)

    def _is_lost(self, frame: "TangentFrame", candidate: float) -> bool:
        """True when the kite is further off than the eight is wide and the scan's `candidate` is much nearer."""
        point = self._point
        distance = frame.distance_to(point.x, point.y, point.z)
        if distance < self.curve.half_width:
            return False
        x, y, z, _, _, _ = self.curve.at(candidate)
        return frame.distance_to(x, y, z) < 0.7 * distance

    def _aim(self, frame: "TangentFrame", gain: float) -> None:
        """Target turning angle: T + L (t . gamma_t) t, with T the curve's tangent carried to the kite.

        The frame's `up` and `across` are written out: four calls in each tick.
        """
        point = self._point
        e1x = frame.e1x
        e1y = frame.e1y
        e1z = frame.e1z
        e2x = frame.e2x
        e2y = frame.e2y
        x = point.x
        y = point.y
        z = point.z
        dx = point.dx
        dy = point.dy
        dz = point.dz
        cosine = frame.x * x + frame.y * y + frame.z * z
        up = e1x * x + e1y * y + e1z * z
        across = e2x * x + e2y * y
        # Carried along the geodesic: T = T_t - (gamma . T_t) / (1 + gamma . gamma_t) (gamma + gamma_t).
        carry = (frame.x * dx + frame.y * dy + frame.z * dz) / (1.0 + (cosine if cosine > -0.999 else -0.999))
        scale = self.curve.direction / point.pace
        tangent_up = (e1x * dx + e1y * dy + e1z * dz - carry * up) * scale
        tangent_across = (e2x * dx + e2y * dy - carry * across) * scale
        side = tangent_up * across - tangent_across * up  # t . gamma_t with t = gamma x T
        self._along = atan2(tangent_across, tangent_up)
        self._side = side
        self._cosine = cosine
        target_course = (self._along + atan(gain * side)) % TWO_PI
        self.target_course = target_course - TWO_PI if target_course > pi else target_course
        distance = atan2(sqrt(up * up + across * across), cosine)
        self.cross_track = distance if side >= 0.0 else -distance
