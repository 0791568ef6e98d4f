"""The two sides of the turning-rate law, row by row of a recorded flight.

    d(psi)/dt = K Va u + offset + c2 / Va sin(psi) cos(elevation) + transport

(Erhard and Strauch, 2013; Baayen, 2012, equation 1), u the steering a lag earlier. Transport is meridian
convergence: a kite that does not turn flies a great circle, on which its angle against the meridian changes. While the
azimuth grows by d(lambda), the meridians at the kite turn by sin(elevation) d(lambda) about its position, so that
transport = -sin(elevation) d(azimuth)/dt; for a kite that moves along its nose at the angular rate w, that is
w sin(psi) tan(elevation). It is taken from the recorded azimuth.

The rate is the slope of the straight line through `smoothing_s` of the angle (Savitzky and Golay, order 2). With
`smooth_both` the right-hand side is averaged over the same rows with the weights that this slope gives to the rate
at each of them, so that both sides are smoothed alike.
"""

from typing import NamedTuple

import numpy as np

from kite_analysis.figure_eight import Array
from kite_analysis.flights.description import FlightDataError
from kite_analysis.flights.record import FlightRecord, stretches


class LawRows(NamedTuple):
    """The rows (m,) of a record of n rows in which all is known; see the module."""

    rows: Array  # (m,), indices into the record
    rate: Array  # (m,), of the angle [rad/s]
    transport: Array  # (m,), its part that is the meridians' [rad/s]; zeros if it is not asked for
    airspeed: Array  # (n,) [m/s]
    gravity: Array  # (n,), sin(psi) cos(elevation) / Va [s/m]
    steering: Array  # (n,)
    kernel: Array  # weights of the average over neighbouring rows
    period_s: float


def choose(record: FlightRecord, angle: str | None, transport: bool | None) -> tuple[str, bool]:
    """The angle to use (heading if there is one), and whether meridian convergence can be allowed for.

    Raises:
        FlightDataError: what is needed, or was asked for, is not in the record.
    """
    for quantity in ("elevation", "airspeed"):
        if not record.has(quantity):
            raise FlightDataError(f"no {quantity} in the part that is used")
    if not record.has("steering") and not record.has("set_steering"):
        raise FlightDataError("no steering in the part that is used")
    angle = angle or ("heading" if record.has("heading") else "course")
    if not record.has(angle):
        raise FlightDataError(f"no {angle} in the part that is used")
    if transport and not record.has("azimuth"):
        raise FlightDataError("meridian convergence needs the azimuth, which is missing")
    return angle, record.has("azimuth") if transport is None else transport


def law_rows(record: FlightRecord, angle: str, transport: bool, smooth_both: bool | None = None,
             lags_s: tuple[float, float] = (0.0, 0.0)) -> LawRows:
    """All rows in unbroken stretches of what is selected where the steering is known at all of `lags_s` (from, to)."""
    half = max(1, round(0.5 * (record.smoothing_s / record.period_s - 1.0)))
    offsets = np.arange(-half, half + 1)
    slope = offsets / np.sum(offsets**2) / record.period_s
    both = record.smooth_both if smooth_both is None else smooth_both
    kernel = _weights_of_rate(slope) * record.period_s if both else np.ones(1)
    psi = getattr(record, angle)
    steering = record.steering if record.has("steering") else record.set_steering
    needed = [psi, record.elevation, record.airspeed] + ([record.azimuth] if transport else [])
    usable = record.selected & np.all(np.isfinite(needed), axis=0) & (record.airspeed > 0.0)
    usable &= _known_at_lags(steering, lags_s, record.period_s)
    rate, turning = np.full(len(psi), np.nan), np.zeros(len(psi))
    for part in stretches(usable, 2 * half + 2):
        middle = slice(part.start + half, part.stop - half)
        rate[middle] = np.correlate(psi[part], slope, "valid")
        if transport:
            turning[middle] = -np.sin(record.elevation[middle]) * np.correlate(record.azimuth[part], slope, "valid")
    rows = np.flatnonzero(np.isfinite(rate))
    gravity = np.sin(psi) * np.cos(record.elevation) / np.where(record.airspeed > 0.0, record.airspeed, np.nan)
    return LawRows(rows, rate[rows], turning[rows], record.airspeed, gravity, steering, kernel, record.period_s)


def regressors(data: LawRows, lag_s: float) -> Array:
    """The regressors of K, the offset and the gravity constant: (m, 3)."""
    turning = _averaged(data.airspeed * shifted(data.steering, lag_s / data.period_s), data)
    return np.column_stack([turning, np.ones(len(data.rows)), _averaged(data.gravity, data)])


def shifted(values: Array, samples: float) -> Array:
    """`values` (n,) as they were `samples` before, straight between rows; NaN beyond the ends."""
    whole = int(np.floor(samples))
    share = samples - whole
    index = np.arange(len(values)) - whole
    later = _at(values, index)
    return later if share == 0.0 else (1.0 - share) * later + share * _at(values, index - 1)


def _at(values: Array, index: Array) -> Array:
    inside = (index >= 0) & (index < len(values))
    return np.where(inside, values[np.clip(index, 0, len(values) - 1)], np.nan)


def _averaged(values: Array, data: LawRows) -> Array:
    if len(data.kernel) == 1:
        return values[data.rows]
    return np.correlate(values, data.kernel, "same")[data.rows]


def _weights_of_rate(slope: Array) -> Array:
    """How much the rate at each row counts in a slope that weighs the angles by `slope`, which add up to 0.

    The angles are the rates added up from row to row, each step the mean of the rates at its two ends.
    """
    steps = -np.cumsum(slope)[:-1]
    return 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))


def _known_at_lags(steering: Array, lags_s: tuple[float, float], period_s: float) -> Array:
    """True where `steering` (n,) is known at all lags between the two of `lags_s`."""
    back, ahead = int(np.ceil(lags_s[1] / period_s)), int(np.ceil(-lags_s[0] / period_s))
    unknown = np.cumsum(np.concatenate([[0], ~np.isfinite(steering)]))
    first, last = np.arange(len(steering)) - back, np.arange(len(steering)) + ahead
    inside = (first >= 0) & (last < len(steering))
    return inside & (unknown[np.clip(last + 1, 0, len(steering))] == unknown[np.clip(first, 0, len(steering))])
