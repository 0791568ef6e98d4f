"""A kite on the unit sphere that obeys the turning-rate law.

    d(psi)/dt = K Va u + offset + c2 / Va sin(psi) cos(elevation)

on top of meridian convergence, so that a kite that does not turn flies a great circle. Sources: J. H. Baayen
(2012), equation 1; M. Erhard and H. Strauch, "Control of towing kites for seagoing vessels" (2013), for gravity and
for the airspeed of the glide law, Va = wind along the tether * glide ratio.

The constant law scales with the wind's speed and its gusts along, and knows neither direction nor height. The glide
law takes the whole wind at the kite's height. Without wind the kite stands still and does not turn.
"""

from math import atan2, cos, sin, sqrt
from typing import Final

from sim_bridge.plants.truth import Truth, Vector
from sim_bridge.plants.turning_rate_settings import GLIDE, TurningRateSettings
from sim_bridge.wind.air import Air
from sim_bridge.wind.profile import LAWS, wind_at
from sim_bridge.wind.wind_settings import WindSettings

# Of the glide law, at the edge of the wind window [m/s]. Below it the law's turning by itself fades: its gravity term
# has the airspeed below the line.
_LEAST_AIRSPEED: Final = 0.5
_TIDY_STEPS: Final = 256


class TurningRatePlant:
    """State: position gamma, nose h (unit vectors, h tangent at gamma); b = gamma x h completes the body frame.

    Both vectors rotate by Omega = gamma x d(gamma)/dt + r gamma, r the turning rate. Within a step the components of
    Omega in the body frame are held at their midpoint values: exact for constant speed and steering, and of second
    order with gravity and wind.
    """

    def __init__(self, settings: TurningRateSettings, wind: WindSettings, position: Vector, direction: Vector):
        self.step_s = settings.step_s
        self.trouble: str | None = None
        self._turn_k = settings.turn_k
        self._length = settings.line_length_m
        self._gravity = settings.gravity_m_s2
        self._offset = settings.offset_rad_s
        self._transport = settings.transport
        self._glide = settings.glide_ratio if settings.speed_law == GLIDE else 0.0
        self._wind = wind.speed_m_s
        self._law = LAWS[wind.profile]
        self._exponent = wind.exponent
        self._airspeed = settings.airspeed_m_s
        self._speed = settings.speed_over_length
        self._constant = not (self._gravity or self._glide or not self._transport)
        self._air = Air(self._wind or 1.0)  # until the first step; a kite that stands still cannot be led to its start
        self._share = 1.0  # of the constant law's airspeed and speed
        self._position = position
        self._nose = direction
        self._steps = 0

    def airspeed(self) -> float:
        """Apparent wind speed [m/s]."""
        return self._glide_airspeed(self._wind_here()) if self._glide else self._airspeed * self._share

    def step(self, dt: float, steering: float, air: Air) -> None:
        """Fly on by `dt` [s]; see Plant."""
        self._air = air
        wind = self._wind
        self._share = air.gust * (air.speed_m_s / wind if wind else 1.0)
        position, nose = self._position, self._nose
        turning, forward, sideways = self._rates(steering)
        if not self._constant:
            self._position, self._nose = _rotated(position, nose, turning, forward, sideways, 0.5 * dt)
            turning, forward, sideways = self._rates(steering)
        self._position, self._nose = _rotated(position, nose, turning, forward, sideways, dt)
        self._steps += 1
        if self._steps % _TIDY_STEPS == 0:
            self._tidy()

    def truth(self) -> Truth:
        """The present state; see Plant."""
        (x, y, z), (hx, hy, hz) = self._position, self._nose
        _, forward, sideways = self._rates(0.0)
        bx, by, bz = y * hz - z * hy, z * hx - x * hz, x * hy - y * hx
        vx, vy, vz = forward * hx + sideways * bx, forward * hy + sideways * by, forward * hz + sideways * bz
        heading = atan2(hx * y - hy * x, hz)
        course = atan2(vx * y - vy * x, vz) if forward or sideways else heading
        return Truth(self._position, (vx, vy, vz), course, heading, self._length, self.airspeed(), 0.0)

    def _wind_here(self) -> Vector:
        """The wind at the kite [m/s]."""
        return wind_at(self._air, self._law, self._exponent, self._length * self._position[2])

    def _glide_airspeed(self, wind: Vector) -> float:
        (x, y, z), (wx, wy, wz), glide = self._position, wind, self._glide
        least = _LEAST_AIRSPEED * min(1.0, sqrt(wx * wx + wy * wy + wz * wz))  # none in no wind
        return max(least, wx * glide * x + wy * glide * y + wz * glide * z)

    def _rates(self, steering: float) -> tuple[float, float, float]:
        """Turning rate [rad/s] and speed over length along the nose and along b [1/s]."""
        if self._constant:
            airspeed = self._airspeed * self._share
            fade = airspeed / _LEAST_AIRSPEED if airspeed < _LEAST_AIRSPEED else 1.0
            return self._turn_k * airspeed * steering + self._offset * fade, self._speed * self._share, 0.0
        (x, y, z), (hx, hy, hz) = self._position, self._nose
        if self._glide:
            wx, wy, wz = wind = self._wind_here()
            airspeed = self._glide_airspeed(wind)
            bx, by, bz = y * hz - z * hy, z * hx - x * hz, x * hy - y * hx
            forward = (airspeed + (wx * hx + wy * hy + wz * hz)) / self._length
            sideways = (wx * bx + wy * by + wz * bz) / self._length
        else:
            airspeed = self._airspeed * self._share
            forward, sideways = self._speed * self._share, 0.0
        drop = hx * y - hy * x  # sin(psi) cos(elevation)
        fade = airspeed / _LEAST_AIRSPEED if airspeed < _LEAST_AIRSPEED else 1.0
        turning = self._turn_k * airspeed * steering + self._offset * fade
        if self._gravity:
            turning += self._gravity / (airspeed if airspeed > _LEAST_AIRSPEED else _LEAST_AIRSPEED) * fade * drop
        if not self._transport:  # hold the turning angle on a straight flight: undo meridian convergence
            turning -= forward * drop * z / max(1e-3, x * x + y * y)
        return turning, forward, sideways

    def _tidy(self) -> None:
        """Take rounding errors out of lengths and right angle."""
        (x, y, z), (hx, hy, hz) = self._position, self._nose
        size = sqrt(x * x + y * y + z * z)
        x, y, z = x / size, y / size, z / size
        along = hx * x + hy * y + hz * z
        hx, hy, hz = hx - along * x, hy - along * y, hz - along * z
        size = sqrt(hx * hx + hy * hy + hz * hz)
        self._position, self._nose = (x, y, z), (hx / size, hy / size, hz / size)


def _rotated(position: Vector, nose: Vector, turning: float, forward: float, sideways: float, dt: float
             ) -> tuple[Vector, Vector]:
    """Both vectors after turning about Omega = turning gamma - sideways h + forward b for `dt` (Rodrigues)."""
    (x, y, z), (hx, hy, hz) = position, nose
    rate = sqrt(turning * turning + forward * forward + sideways * sideways)
    if rate == 0.0:
        return position, nose
    bx, by, bz = y * hz - z * hy, z * hx - x * hz, x * hy - y * hx
    r, p, q = turning / rate, forward / rate, sideways / rate
    sine = sin(rate * dt)
    cosine = cos(rate * dt)
    rest = 1.0 - cosine
    nx, ny, nz = r * x - q * hx + p * bx, r * y - q * hy + p * by, r * z - q * hz + p * bz
    a, b = r * rest, q * rest
    return (
        (cosine * x + sine * (p * hx + q * bx) + a * nx,
         cosine * y + sine * (p * hy + q * by) + a * ny,
         cosine * z + sine * (p * hz + q * bz) + a * nz),
        (cosine * hx + sine * (r * bx - p * x) - b * nx,
         cosine * hy + sine * (r * by - p * y) - b * ny,
         cosine * hz + sine * (r * bz - p * z) - b * nz),
    )
