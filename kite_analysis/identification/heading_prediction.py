"""How well a law predicts the heading of a flight that it was not fitted to.

The law is integrated open loop over short windows, from the recorded angle at each window's start, with the recorded
airspeed, elevation and azimuth, and either the actual steering as recorded or what the actuator's model makes of the
commanded steering. The angle in the gravity term is the predicted one. A window starts at every row after which it fits
into an unbroken stretch, so that the result does not depend on where windows begin.

Candidates, on the three public cycles, each predicted from fits on the others (one cycle 6 times, two 3 times): the
worst and the mean of these nine, RMS in degrees over 2 s / 5 s, and the same from the commanded steering.

    law                                   actual: worst  mean         set: worst    mean
    plain, rate alone smoothed             4.99 / 10.08  4.08 / 7.93  5.03 / 10.17  4.34 / 8.45
    plain, both sides smoothed             4.82 /  9.47  4.06 / 7.86  4.93 /  9.83  4.36 / 8.57
    meridian convergence, rate smoothed      4.84 /  9.82  4.08 / 8.06  4.65 /  9.76  4.30 / 8.45
    meridian convergence, both (used)        4.68 /  9.26  4.03 / 7.90  4.63 /  9.93  4.30 / 8.49

Without the lag they come out within 0.4 deg of these. A further term in the sideslip (course less heading), in |u| u
or in cos(psi) / Va made the worst case 0.2 deg better to 0.6 deg worse: K differs by 4 % from cycle to cycle, and what
is left of the rate, 3 to 4 deg/s RMS, forgets itself within a second, as gusts do.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kite_analysis.figure_eight import Array
from kite_analysis.flights.description import FlightDataError
from kite_analysis.flights.record import FlightRecord, stretches
from kite_analysis.identification.actuator_fit import identify_actuator
from kite_analysis.identification.actuator_model import ActuatorModel, follow
from kite_analysis.identification.turning_rate_fit import LawFit, identify_together

ACTUAL, COMMANDED = "actual", "commanded"


class TurningModel(NamedTuple):
    """What predicts: the law, and the actuator for predictions from the commanded steering."""

    law: LawFit
    actuator: ActuatorModel | None = None


class PredictionError(NamedTuple):
    """Error of the predicted angle over all samples of all windows."""

    rms_deg: float
    end_rms_deg: float  # at the windows' ends alone
    windows: int
    window_s: float
    source: str


def fit_model(records: Sequence[FlightRecord], angle: str | None = None) -> TurningModel:
    """The model of the kite that flew `records`: one law for all of them, both sides smoothed alike.

    The actuator is the mean of those of the flights; None if a commanded or an actual steering is missing.

    Raises:
        FlightDataError: the flights do not determine it.
    """
    law = identify_together(list(records), angle, smooth_both=True)
    if not all(record.has("steering") and record.has("set_steering") for record in records):
        return TurningModel(law)
    fits = [identify_actuator(record) for record in records]
    return TurningModel(law, ActuatorModel(
        float(np.mean([fit.dead_time_s for fit in fits])), _mean_limit([fit.rate_limit_per_s for fit in fits]),
        _mean_limit([fit.saturation for fit in fits])))


def predict_heading(records: Sequence[FlightRecord], window_s: float, source: str, model: TurningModel
                    ) -> PredictionError:
    """Error over windows of `window_s` [s] in the selected rows of `records`; `source` is "actual" or "commanded".

    Raises:
        FlightDataError: no window fits, or the model has no actuator to predict with.
        ValueError: `source` is neither of the two.
    """
    if source not in (ACTUAL, COMMANDED):
        raise ValueError(f"source {source!r} is neither \"{ACTUAL}\" nor \"{COMMANDED}\"")
    if source == COMMANDED and model.actuator is None:
        raise FlightDataError("a prediction from the commanded steering needs the actuator's model")
    errors = [window_errors(record, window_s, source, model) for record in records]
    squares = np.concatenate([error**2 for error in errors], axis=1)
    if not squares.size:
        raise FlightDataError(f"no unbroken stretch holds a window of {window_s:g} s")
    rms_deg, end_rms_deg = np.degrees(np.sqrt([np.mean(squares), np.mean(squares[-1])]))
    return PredictionError(float(rms_deg), float(end_rms_deg), squares.shape[1], window_s, source)


def window_errors(record: FlightRecord, window_s: float, source: str, model: TurningModel) -> Array:
    """Predicted less recorded angle [rad], (steps, windows); Heun's method with a step a row."""
    law = model.law
    steps = max(1, round(window_s / record.period_s))
    psi = getattr(record, law.angle)
    transport = _transport_rate(record) if law.transport else np.zeros(len(psi))
    starts = _starts(record, psi, transport, steps, source, law.lag_s or 0.0)
    index = starts + np.arange(steps + 1)[:, None]
    steering = _steering(record, index, source, model)
    forced = (law.k_rad_per_m * record.airspeed[index] * steering + law.offset_rad_s + transport[index])
    gravity = law.gravity_m_s2 * np.cos(record.elevation[index]) / record.airspeed[index]
    angle = psi[starts]
    errors = np.empty((steps, len(starts)))
    for row in range(steps):
        before = forced[row] + gravity[row] * np.sin(angle)
        after = forced[row + 1] + gravity[row + 1] * np.sin(angle + record.period_s * before)
        angle = angle + 0.5 * record.period_s * (before + after)
        errors[row] = angle - psi[starts + row + 1]
    return errors


def cross_fits(records: Sequence[FlightRecord]) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """(fitted to, predicted), as indices: every record from each single other one, and from all others together."""
    everyone = range(len(records))
    pairs = [((one,), (other,)) for one in everyone for other in everyone if one != other]
    if len(records) > 2:
        pairs += [(tuple(one for one in everyone if one != other), (other,)) for other in everyone]
    return pairs


def cross_predictions(records: Sequence[FlightRecord], windows_s: Sequence[float] = (2.0, 5.0),
                      sources: Sequence[str] = (ACTUAL, COMMANDED)) -> list[PredictionError]:
    """The worst of the cross-fits for each source and window; no flight is predicted by a model fitted to it.

    Raises:
        FlightDataError: the flights do not determine it; at least two are needed.
    """
    if len(records) < 2:
        raise FlightDataError("cross-fits need at least two flights")
    tried = [(fit_model([records[index] for index in fitted]), [records[index] for index in predicted])
             for fitted, predicted in cross_fits(records)]
    return [max((predict_heading(others, window_s, source, model) for model, others in tried),
                key=lambda error: error.rms_deg)
            for source in sources for window_s in windows_s]


def _mean_limit(limits: list[float | None]) -> float:
    known = [limit for limit in limits if limit is not None]
    return float(np.mean(known)) if known else np.inf


def _transport_rate(record: FlightRecord) -> Array:
    """Turning of the meridians at every row [rad/s], from the azimuth over the neighbouring rows."""
    rate = np.full(len(record.azimuth), np.nan)
    rate[1:-1] = (record.azimuth[2:] - record.azimuth[:-2]) / (2.0 * record.period_s)
    return -np.sin(record.elevation) * rate


def _starts(record: FlightRecord, psi: Array, transport: Array, steps: int, source: str, lag_s: float) -> Array:
    """Rows at which a window of `steps` fits, with the steering known as far back as it matters."""
    usable = record.selected & np.all(np.isfinite([psi, transport, record.elevation, record.airspeed]), axis=0)
    usable &= np.isfinite(record.steering) & (record.airspeed > 0.0)
    if source == COMMANDED:
        usable &= np.isfinite(record.set_steering)
    reach = int(np.ceil(abs(lag_s) / record.period_s)) + 1
    parts = [np.arange(part.start + reach, part.stop - reach - steps)
             for part in stretches(usable, steps + 1 + 2 * reach)]
    return np.concatenate(parts) if parts else np.empty(0, dtype=int)


def _steering(record: FlightRecord, index: Array, source: str, model: TurningModel) -> Array:
    """The steering at the law's lag before the rows `index` (steps + 1, windows): recorded up to the start."""
    back = (model.law.lag_s or 0.0) / record.period_s
    whole = int(np.floor(back))
    share = back - whole
    if source == ACTUAL:
        return (1.0 - share) * record.steering[index - whole] + share * record.steering[index - whole - 1]
    assert model.actuator is not None
    starts = index[0]
    ahead = max(0, -whole)
    position = follow(model.actuator, np.nan_to_num(record.set_steering), record.period_s, starts,
                      record.steering[starts], len(index) - 1 + ahead)
    behind = max(0, whole + 1)
    known = record.steering[starts + np.arange(-behind, 0)[:, None]]
    position = np.concatenate([known, position])
    rows = np.arange(len(index)) + behind - whole
    return (1.0 - share) * position[rows] + share * position[rows - 1]
