"""Outer loop: the nearest point of the target curve, and the direction that leads onto it.

J. H. Baayen, "Trajectory tracking control of kites with system delay" (2012), section 2.2.
"""

from math import atan, atan2, cos, pi, sin, sqrt

from .generated_parameters import FF_FILTER, OUTER_L
from .sphere import wrap

_ITERATIONS = 5
_CLOSE_ENOUGH = 1e-4  # step in s at which the search ends [rad]
_LONGEST_STEP = 0.2  # in s [rad], short enough not to reach another strand
_SCAN_POINTS = 32
_SCAN_STEP = 2.0 * pi / _SCAN_POINTS
_COURSE_WEIGHT = 0.2  # how much flying the right way counts beside being near, when a strand is picked anew


class GuidanceConfig:
    """Settings of the outer loop: gain `l`, `filter_time` [s] of the target's rate."""

    def __init__(self):
        self.gain_l = 0.0
        self.filter_time = 0.0

    def load(self, values):
        """Take the parameters over from their `values`."""
        self.gain_l = values[OUTER_L]
        self.filter_time = values[FF_FILTER]


class Guidance:
    """State of the outer loop; angles in radians, `cross_track` positive when the curve lies on the side gamma x T."""

    def __init__(self, curve):
        self.curve = curve
        self.config = GuidanceConfig()
        self.path_parameter = 0.0
        self.target_course = 0.0
        self.target_rate = 0.0  # [rad/s]
        self.cross_track = 0.0
        self.running = False  # True while a strand is followed
        self._scan_index = 0
        self._scan_best = -9.0
        self._scan_best_s = 0.0
        self._candidate = None

    def stop(self):
        """Forget the strand: the next step picks the best one anew."""
        self.running = False
        self.target_rate = 0.0

    def scan(self, frame, course):
        """Look at one more point of the whole curve, so that a far kite finds its way without a costly search."""
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

    def step(self, frame, dt):
        """Update the target for the kite at `frame`, `dt` [s] after the step before."""
        fresh = not self.running
        if fresh and self._candidate is not None:
            self.path_parameter = self._candidate
        point = self._nearest(frame)
        if self._candidate is not None and self._is_lost(frame, point):
            fresh = True
            self.path_parameter = self._candidate
            point = self._nearest(frame)
        self.running = True
        before = self.target_course
        self._aim(frame, point)
        if fresh or dt <= 0.0:
            self.target_rate = 0.0
        else:
            rate = wrap(self.target_course - before) / dt
            self.target_rate += (rate - self.target_rate) * dt / (dt + self.config.filter_time)

    def _nearest(self, frame):
        """Ascend the cosine of the distance from the last solution; return position and derivative there.

        The first step is Gauss-Newton's, the next ones take the curvature from the change of the slope and stay
        within twice Gauss-Newton's and within _LONGEST_STEP, so that the search stays on its strand.
        """
        curve = self.curve
        s = self.path_parameter
        step = last_slope = 0.0
        for iteration in range(_ITERATIONS):
            point = curve.at(s)
            _, _, _, dx, dy, dz = point
            slope = frame.x * dx + frame.y * dy + frame.z * dz
            longest = abs(slope) / (dx * dx + dy * dy + dz * dz)
            curvature = (last_slope - slope) / step if iteration and step else 0.0
            if iteration and curvature > 0.0:
                longest = min(2.0 * longest, abs(slope) / curvature)
            longest = min(longest, _LONGEST_STEP)
            step = longest if slope > 0.0 else -longest
            last_slope = slope
            s += step
            if longest < _CLOSE_ENOUGH:
                break
        else:
            point = curve.at(s)
        self.path_parameter = s % (2.0 * pi)
        return point

    def _is_lost(self, frame, point):
        """True when the kite is further off than the eight is wide and the scan knows a much nearer place."""
        distance = frame.distance_to(point[0], point[1], point[2])
        if distance < self.curve.half_width:
            return False
        other = self.curve.at(self._candidate)
        return frame.distance_to(other[0], other[1], other[2]) < 0.7 * distance

    def _aim(self, frame, point):
        """Target turning angle: T + L (t . gamma_t) t, with T the curve's tangent carried to the kite."""
        x, y, z, dx, dy, dz = point
        scale = self.curve.direction / sqrt(dx * dx + dy * dy + dz * dz)
        cosine = frame.x * x + frame.y * y + frame.z * z
        up = frame.up(x, y, z)
        across = frame.across(x, y)
        # Carried along the geodesic: T = T_t - (gamma . T_t) / (1 + gamma . gamma_t) (gamma + gamma_t).
        carry = (frame.x * dx + frame.y * dy + frame.z * dz) / (1.0 + max(cosine, -0.999))
        tangent_up = (frame.up(dx, dy, dz) - carry * up) * scale
        tangent_across = (frame.across(dx, dy) - carry * across) * scale
        side = tangent_up * across - tangent_across * up  # t . gamma_t with t = gamma x T
        self.target_course = wrap(atan2(tangent_across, tangent_up) + atan(self.config.gain_l * side))
        distance = atan2(sqrt(up * up + across * across), cosine)
        self.cross_track = distance if side >= 0.0 else -distance
