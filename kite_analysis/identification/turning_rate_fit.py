"""The turning-rate law, identified from a flight by least squares; the equation is in `turning_rates`.

Effect of the choices, on the reel-out of the three public cycles in tests/data/flight: meridian convergence
takes 4 to 8 % off the power of the residual, and 0.6 to 1.1 m/s2 off the gravity constant, into which most of it
goes if it is left out; smoothing both sides instead of the rate alone adds 1.1 to 1.4 % to K, by which the smoothing
over 1.1 s flattens sharp turns.
"""

from typing import NamedTuple

import numpy as np

from kite_analysis.figure_eight import Array
from kite_analysis.flights.checks import check_period
from kite_analysis.flights.description import FlightDataError
from kite_analysis.flights.record import FlightRecord
from kite_analysis.identification.fit_quality import blocked_std, r_squared
from kite_analysis.identification.turning_rates import LawRows, choose, law_rows, regressors

_LEAST_S = 5.0
_LEAST_STEERING = 1e-3
_BLOCK_S = 8.0
_LAGS_S = {"actual": (-0.3, 1.0), "commanded": (-0.3, 2.5)}
_COARSE_S = 0.05
_LEAST_INDEPENDENT = 1e-6
_GOLDEN = 0.5 * (5.0**0.5 - 1.0)


class LawFit(NamedTuple):
    """The law, as identified; `_std` are standard deviations (see `blocked_std`).

    `lag_s` is that of the angle's rate on the steering; None if the best one lies at an end of the search, and then
    the rest is without a lag. `steering`: "actual", or "commanded" if the actual steering is missing.
    """

    angle: str
    transport: bool
    steering: str
    k_rad_per_m: float
    k_rad_per_m_std: float
    gravity_m_s2: float
    gravity_m_s2_std: float
    offset_rad_s: float
    offset_rad_s_std: float
    lag_s: float | None
    lag_s_std: float | None
    r2: float
    seconds: float


def identify_law(record: FlightRecord, angle: str | None = None, transport: bool | None = None,
                 smooth_both: bool | None = None) -> LawFit:
    """Fit K, gravity, offset and lag to the selected rows of `record`.

    `angle` is "heading" or "course" (default: heading if there is one); `transport` None means where there is an
    azimuth; `smooth_both` (see `turning_rates`) None means as the record has it.

    Raises:
        FlightDataError: something is missing, or this flight does not determine it.
    """
    return identify_together([record], angle, transport, smooth_both)


def identify_together(records: list[FlightRecord], angle: str | None = None, transport: bool | None = None,
                      smooth_both: bool | None = None) -> LawFit:
    """Fit one law to several flights of the same kite; see `identify_law`."""
    angle, transport = choose(records[0], angle, transport)
    steering = "actual" if records[0].has("steering") else "commanded"
    parts = [law_rows(record, *choose(record, angle, transport), smooth_both, _LAGS_S[steering])
             for record in records]
    seconds = float(np.sum([len(part.rows) * part.period_s for part in parts]))
    for record in records:
        check_period(record.period_s)
    _check_excitation(parts, seconds, angle)
    turned = np.concatenate([part.rate - part.transport for part in parts])

    def design(lag_s: float) -> Array:
        return np.concatenate([regressors(part, lag_s) for part in parts])

    def residual_power(lag_s: float) -> float:
        matrix = design(lag_s)
        return float(np.sum((turned - matrix @ _solve(matrix, turned)) ** 2))

    best_lag_s = _least(residual_power, *_LAGS_S[steering])
    lag_s = best_lag_s or 0.0
    jacobian = design(lag_s)
    _check_independence(jacobian)
    solution = _solve(jacobian, turned)
    residual = turned - jacobian @ solution
    if best_lag_s is not None:
        step_s = 0.5 * parts[0].period_s
        by_lag = (design(lag_s + step_s)[:, 0] - design(lag_s - step_s)[:, 0]) / (2.0 * step_s)
        jacobian = np.column_stack([jacobian, solution[0] * by_lag])
    stds = blocked_std(jacobian, residual, round(_BLOCK_S / parts[0].period_s))
    k_std, offset_std, gravity_std, *lag_std = (float(value) for value in stds)
    k, offset, gravity = (float(value) for value in solution)
    return LawFit(angle, transport, steering, k, k_std, gravity, gravity_std, offset, offset_std, best_lag_s,
                  next(iter(lag_std), None), r_squared(turned, residual), seconds)


def fitted_rate(data: LawRows, fit: LawFit) -> Array:
    """The rate of the angle [rad/s], (m,), that the law gives in `data`, transport included."""
    return (regressors(data, fit.lag_s or 0.0) @ (fit.k_rad_per_m, fit.offset_rad_s, fit.gravity_m_s2)
            + data.transport)


def rows_for(record: FlightRecord, fit: LawFit) -> LawRows:
    """The rows of `record` in which the law `fit` can be tested."""
    lag_s = fit.lag_s or 0.0
    return law_rows(record, fit.angle, fit.transport, None, (min(lag_s, 0.0), max(lag_s, 0.0)))


def score(record: FlightRecord, fit: LawFit) -> float:
    """R2 of the law `fit`, fitted to other data, on the selected rows of `record`."""
    data = rows_for(record, fit)
    return r_squared(data.rate - data.transport, data.rate - fitted_rate(data, fit))


def _check_excitation(parts: list[LawRows], seconds: float, angle: str) -> None:
    if seconds < _LEAST_S:
        raise FlightDataError(f"only {seconds:.1f} s in which {angle}, elevation, airspeed and steering are known "
                              f"without a gap; at least {_LEAST_S:g} s are needed")
    moved = float(np.std(np.concatenate([part.steering[part.rows] for part in parts])))
    if moved < _LEAST_STEERING:
        raise FlightDataError(f"the steering hardly moves ({moved:.2g} RMS about its mean): K cannot be identified")


def _check_independence(design: Array) -> None:
    size = np.linalg.norm(design, axis=0)
    singular = np.linalg.svd(design / np.where(size > 0.0, size, 1.0), compute_uv=False)
    if singular[-1] < _LEAST_INDEPENDENT * singular[0]:
        raise FlightDataError("the flight is too steady to separate steering, gravity and offset")


def _solve(matrix: Array, values: Array) -> Array:
    """Least squares, of columns scaled alike; the excitation is checked elsewhere."""
    scale = np.linalg.norm(matrix, axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    solution, *_ = np.linalg.lstsq(matrix / scale, values, rcond=None)
    return solution / scale


def _least(power, from_s: float, to_s: float) -> float | None:
    """Where `power` is least: on a coarse grid, then by golden section; None at an end of the grid."""
    grid = np.arange(from_s, to_s + 0.5 * _COARSE_S, _COARSE_S)[1:-1]
    best = int(np.argmin([power(float(lag_s)) for lag_s in grid]))
    if best in (0, len(grid) - 1):
        return None
    low, high = float(grid[best - 1]), float(grid[best + 1])
    inner = [high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)]
    powers = [power(lag_s) for lag_s in inner]
    while high - low > 1e-4:
        if powers[0] < powers[1]:
            high, inner[1], powers[1] = inner[1], inner[0], powers[0]
            inner[0] = high - _GOLDEN * (high - low)
            powers[0] = power(inner[0])
        else:
            low, inner[0], powers[0] = inner[0], inner[1], powers[1]
            inner[1] = low + _GOLDEN * (high - low)
            powers[1] = power(inner[1])
    return 0.5 * (low + high)
