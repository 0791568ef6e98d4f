"""The target curve: a figure of eight on the unit sphere, and whether a kite can fly it.

Azimuth = centre + A sin s, elevation = centre + B sin 2s, for s from 0 to 2 pi.
"""

from math import cos, degrees, pi, radians, sin, sqrt

from ..parameters.generated_parameters import (
    EIGHT_AZIMUTH,
    EIGHT_DIRECTION,
    EIGHT_ELEVATION,
    EIGHT_HALF_H,
    EIGHT_HALF_W,
    EIGHT_LEAST_EL,
    LINE_LENGTH,
    STEER_MAX,
    TURN_K,
    WINDOW_ANGLE,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

_CHECKED_POINTS = 24  # type: Final  # on half of the eight
_POINTS_PER_CALL = 3  # type: Final
_HIGHEST = 85.0  # type: Final  # [deg]

# The parameters on which it depends whether an eight can be flown.
CURVE_PARAMETERS = (
    EIGHT_AZIMUTH, EIGHT_ELEVATION, EIGHT_HALF_H, EIGHT_HALF_W, EIGHT_LEAST_EL, LINE_LENGTH, STEER_MAX, TURN_K,
    WINDOW_ANGLE,
)  # type: Final[tuple[int, ...]]
_LEAST_TURNING = 1e-6  # type: Final  # turning per distance flown [rad/rad] of a kite that hardly steers at all


class FigureEight:
    """The eight as configured: angles in radians, `direction` of flight along s is +1.0 or -1.0."""

    def __init__(self) -> None:
        self.azimuth: float = 0.0
        self.elevation: float = 0.0
        self.half_width: float = 0.0
        self.half_height: float = 0.0
        self.direction: float = 1.0

    def load(self, values: list[float]) -> None:
        """Load the settings from the parameters' `values`."""
        self.azimuth = radians(values[EIGHT_AZIMUTH])
        self.elevation = radians(values[EIGHT_ELEVATION])
        self.half_width = radians(values[EIGHT_HALF_W])
        self.half_height = radians(values[EIGHT_HALF_H])
        self.direction = values[EIGHT_DIRECTION]

    def at(self, s: float) -> tuple[float, float, float, float, float, float]:
        """Unit position at `s` and its derivative by s: (x, y, z, dx, dy, dz)."""
        point = CurvePoint(self)
        point.go_to(s)
        return point.x, point.y, point.z, point.dx, point.dy, point.dz

    def geodesic_curvature(self, s: float) -> float:
        """Turning per distance flown [rad/rad] at `s`, without meridian convergence; the way for each s."""
        point = CurvePoint(self)
        point.go_to(s)
        return point.geodesic_curvature()


class CurvePoint:
    """A point that goes along a `curve`: unit position x, y, z, derivative by s dx, dy, dz, and its length `pace`."""

    def __init__(self, curve: "FigureEight") -> None:
        self._curve = curve
        self.x: float = 1.0
        self.y: float = 0.0
        self.z: float = 0.0
        self.dx: float = 0.0
        self.dy: float = 0.0
        self.dz: float = 0.0
        self.square: float = 0.0  # of the pace
        self.pace: float = 0.0
        self._sin_s: float = 0.0
        self._level: float = 1.0  # cosine of the elevation
        self._height: float = 0.0  # 2 B cos s
        self._east: float = 0.0
        self._azimuth_rate: float = 0.0
        self._elevation_rate: float = 0.0

    def go_to(self, s: float) -> None:
        """Go to `s`."""
        curve = self._curve
        sin_s = self._sin_s = sin(s)
        cos_s = cos(s)
        rise = 2.0 * curve.half_height
        height = self._height = rise * cos_s
        azimuth_rate = self._azimuth_rate = curve.half_width * cos_s
        elevation_rate = self._elevation_rate = rise - 2.0 * rise * sin_s * sin_s
        azimuth = curve.azimuth + curve.half_width * sin_s
        elevation = curve.elevation + height * sin_s
        cos_azimuth = cos(azimuth)
        sin_azimuth = sin(azimuth)
        level = self._level = cos(elevation)
        sin_elevation = self.z = sin(elevation)
        east = self._east = level * azimuth_rate
        inward = sin_elevation * elevation_rate
        self.x = level * cos_azimuth
        self.y = level * sin_azimuth
        self.dx = -inward * cos_azimuth - east * sin_azimuth
        self.dy = east * cos_azimuth - inward * sin_azimuth
        self.dz = level * elevation_rate
        square = self.square = elevation_rate * elevation_rate + east * east
        self.pace = sqrt(square)

    def geodesic_curvature(self) -> float:
        """Turning per distance flown [rad/rad] here, without meridian convergence.

        With east = cos(elevation) azimuth': (east elevation'' - east' elevation') / w^2 + east tan(elevation), over w,
        the way for each s.
        """
        rate = self._elevation_rate
        convergence = self.z * self._azimuth_rate  # east tan(elevation)
        turning = (self._level * self._curve.half_width * self._sin_s + convergence * rate) * rate
        turning -= 4.0 * self._height * self._sin_s * self._east
        return (turning / self.square + convergence) / self.pace


class CurveCheck:
    """Checks whether a kite can fly an eight: a few points per call, so that no tick takes long.

    The tightest turn that a kite can fly has the angular radius 1 / (line length * K * u_max), whatever its speed.
    The eight's two halves are mirror images, so only one is checked: the one further from downwind.
    """

    def __init__(self) -> None:
        self._curve = FigureEight()
        self._first: float = 0.0  # the s that the half begins with
        self._next: int = 0
        self._most_curvature: float = 0.0
        self._curvature: float = 0.0
        self._window: float = 0.0
        self._window_angle: float = 0.0
        self.done: bool = False
        self.problem: str | None = None  # in at most 50 characters, when done

    def begin(self, values: list[float], line_length: float) -> None:
        """Start on the eight of the parameters' `values`, flown on a line of `line_length` [m]."""
        curve = self._curve
        curve.load(values)
        self._first = 0.0 if curve.azimuth >= 0.0 else pi
        self._next = 0
        self._curvature = 0.0
        self._most_curvature = max(_LEAST_TURNING, line_length * values[TURN_K] * values[STEER_MAX])
        self._window_angle = values[WINDOW_ANGLE]
        self._window = cos(radians(values[WINDOW_ANGLE]))
        self.problem = None
        least = values[EIGHT_ELEVATION] - values[EIGHT_HALF_H]
        if least < values[EIGHT_LEAST_EL]:
            self.problem = "eight goes down to %.1f deg, minimum is %.1f" % (least, values[EIGHT_LEAST_EL])
        elif values[EIGHT_ELEVATION] + values[EIGHT_HALF_H] > _HIGHEST:
            self.problem = "eight goes over the zenith"
        self.done = self.problem is not None

    def advance(self) -> None:
        """Check the next few points."""
        for _ in range(_POINTS_PER_CALL):
            if self.done:
                return
            s = self._first + pi * self._next / _CHECKED_POINTS
            if self._curve.at(s)[0] < self._window:
                self.problem = "eight leaves the wind window of %.0f deg" % self._window_angle
            curvature = abs(self._curve.geodesic_curvature(s))
            if not curvature <= self._curvature:
                self._curvature = curvature
            self._next += 1
            if self._next == _CHECKED_POINTS and self._curvature > self._most_curvature:
                self.problem = "eight needs %.1f deg radius, kite manages %.3g" % (
                    degrees(1.0 / self._curvature), degrees(1.0 / self._most_curvature))
            self.done = self.problem is not None or self._next == _CHECKED_POINTS
