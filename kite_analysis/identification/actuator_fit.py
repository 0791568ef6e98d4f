"""The steering actuator, identified from commanded and actual steering: dead time, rate limit, saturation.

Dead time, rate limit and saturation are first found together, by least squares between the model's position and the
recorded one; the model restarts from the recorded position every 10 s. A real actuator takes time to get up to
speed, which such a fit absorbs in a lower rate limit. The rate limit is therefore measured where, by the model,
it has long been reached: the mean speed over the middle of each long slew. The dead time is then the best one for
that rate limit, so that it holds the time to get up to speed as well: what the tangent to a step response gives.
On the three public cycles the fit of all three gives 0.45, 0.47 and 0.44 s with 0.196 to 0.207 per second, this way
0.48, 0.48 and 0.46 s with 0.211, the speed at which the recorded slews do run. From one slew to the next the tangent's
dead time varies by 0.12 s RMS, which is most of the standard deviation.

The dead time counts from the recorded command. For a run log that is when the command leaves the firmware: the delay
of the steering's link is part of it.
"""

from typing import NamedTuple

import numpy as np

from kite_analysis.figure_eight import Array
from kite_analysis.flights.description import FlightDataError
from kite_analysis.flights.record import FlightRecord, stretches
from kite_analysis.identification.actuator_model import ActuatorModel, follow
from kite_analysis.identification.fit_quality import blocked_std, r_squared

_BLOCK_S = 10.0
_LONGEST_DEAD_TIME_S = 2.0
_LEAST_STEERING = 1e-3
_MATTERS = 1.05  # a limit that is there makes the residual without it larger by this at least
_FLOOR = 1e-6  # [of the steering's range] residuals below this are rounding
_HALVINGS = 6


class ActuatorFit(NamedTuple):
    """The actuator; None for a limit that the flight never reached. `_std` are standard deviations.

    The dead time's covers the spread over the flight and the uncertainty of when, between two rows, a command came
    (see `FlightRecord.command_slack_s`). `steering_reached` is the largest actual steering: a saturation of None lies
    there or above.
    """

    dead_time_s: float
    dead_time_s_std: float
    rate_limit_per_s: float | None
    rate_limit_per_s_std: float | None
    saturation: float | None
    saturation_std: float | None
    steering_reached: float
    actuator_r2: float

    @property
    def model(self) -> ActuatorModel:
        """To be run over commanded steering."""
        return ActuatorModel(self.dead_time_s, self.rate_limit_per_s or np.inf, self.saturation or np.inf)


class Blocks(NamedTuple):
    """The parts of a flight that the model is run over, side by side."""

    commanded: Array  # (n,), of the whole record, without gaps
    measured: Array  # (rows + 1, blocks)
    used: Array  # (rows + 1, blocks), False in what a shorter block leaves empty
    starts: Array  # (blocks,), rows of the record
    period_s: float

    def run(self, model: ActuatorModel) -> Array:
        """Positions (rows + 1, ..., blocks)."""
        return follow(model, self.commanded, self.period_s, self.starts, self.measured[0], len(self.measured) - 1)

    def power(self, dead_time_s: Array, rate: Array, saturation: Array) -> Array:
        """Sum of squared residuals for each of the candidates (c,)."""
        model = ActuatorModel(dead_time_s[:, None], rate[:, None], saturation[:, None])
        position = self.run(model)
        return np.sum(np.where(self.used[:, None], position - self.measured[:, None], 0.0) ** 2, axis=(0, 2))


def identify_actuator(record: FlightRecord) -> ActuatorFit:
    """Fit the actuator to the selected rows of `record`.

    Raises:
        FlightDataError: there is no commanded or no actual steering, or it hardly moves.
    """
    for quantity, name in (("steering", "actual"), ("set_steering", "commanded")):
        if not record.has(quantity):
            raise FlightDataError(f"no {name} steering in the part that is used")
    blocks = cut_blocks(record)
    actual = blocks.measured[blocks.used]
    if np.std(actual) < _LEAST_STEERING:
        raise FlightDataError(f"the actual steering hardly moves ({np.std(actual):.2g} RMS about its mean)")
    reached = float(np.quantile(np.abs(actual), 0.995))
    dead_time_s, rate, saturation = _together(blocks, reached)
    rate_std = saturation_std = None
    if np.isfinite(rate):
        plateau = _slew_rate(blocks, ActuatorModel(dead_time_s, rate, saturation))
        if plateau:
            rate, rate_std = plateau
            dead_time_s = _best_dead_time(blocks, dead_time_s, rate, saturation)
    model = ActuatorModel(dead_time_s, rate, saturation)
    residual = _residual(blocks, model)
    unknowns = [("dead_time_s", 0.5 * record.period_s)]
    unknowns += [("rate_limit_per_s", 0.01 * rate)] if np.isfinite(rate) and rate_std is None else []
    unknowns += [("saturation", 0.01 * saturation)] if np.isfinite(saturation) else []
    std = _stds(blocks, model, residual, unknowns)
    rate_std = std.get("rate_limit_per_s", rate_std)
    saturation_std = std.get("saturation")
    # Without a rate limit the position steps from one row to the next, and when in between cannot be seen.
    slack_s = max(record.command_slack_s, 0.0 if np.isfinite(rate) else record.period_s)
    return ActuatorFit(
        dead_time_s, float(np.hypot(std["dead_time_s"], slack_s / np.sqrt(12.0))),
        rate if np.isfinite(rate) else None, rate_std, saturation if np.isfinite(saturation) else None,
        saturation_std, float(np.max(np.abs(actual))), r_squared(actual, residual))


def cut_blocks(record: FlightRecord) -> Blocks:
    """Cut what is selected, and has both steerings over the longest dead time before, into blocks of 10 s.

    Raises:
        FlightDataError: there is no such part.
    """
    before = round(_LONGEST_DEAD_TIME_S / record.period_s)
    known = np.isfinite(record.set_steering)
    gaps = np.cumsum(np.concatenate([[0], ~known]))
    rows = np.arange(len(known))
    settled = (rows >= before) & (gaps[rows + 1] == gaps[np.clip(rows - before, 0, None)])
    usable = record.selected & np.isfinite(record.steering) & settled
    length = round(_BLOCK_S / record.period_s)
    pieces = [(start, min(start + length, part.stop - 1)) for part in stretches(usable, 10)
              for start in range(part.start, part.stop - 1, length)]
    if not pieces:
        raise FlightDataError("no second of flight with both commanded and actual steering")
    starts = np.array([start for start, _ in pieces])
    index = starts + np.arange(length + 1)[:, None]
    used = index <= np.array([stop for _, stop in pieces])
    used[0] = False  # given, not predicted
    measured = record.steering[np.clip(index, 0, len(rows) - 1)]
    return Blocks(np.where(known, record.set_steering, 0.0), np.where(np.isfinite(measured), measured, 0.0), used,
                  starts, record.period_s)


def _together(blocks: Blocks, reached: float) -> tuple[float, float, float]:
    """Dead time, rate limit and saturation by least squares; infinite where a limit explains nothing."""
    speeds = np.abs(np.diff(blocks.measured, axis=0))[blocks.used[1:]] / blocks.period_s
    guess = float(np.quantile(speeds, 0.95))
    delays, rates = (axis.ravel() for axis in np.meshgrid(
        np.arange(0.0, _LONGEST_DEAD_TIME_S, max(0.05, blocks.period_s)), guess * np.array([0.7, 1.0, 1.5, 1e9])))
    power = blocks.power(delays, rates, np.full(len(delays), reached))
    best = int(np.argmin(power))
    point = _refined(blocks, np.array([delays[best], min(rates[best], 20.0 * guess), reached]))
    floor = np.count_nonzero(blocks.used) * _FLOOR**2
    for which in (2, 1):
        without = point.copy()
        without[which] = 1e9
        if blocks.power(*without[:, None])[0] < _MATTERS * blocks.power(*point[:, None])[0] + floor:
            point = without
    dead_time_s, rate, saturation = (float(value) for value in np.where(point >= 1e9, np.inf, point))
    if np.isinf(rate) or np.isinf(saturation):
        dead_time_s = _best_dead_time(blocks, dead_time_s, rate, saturation)
    return dead_time_s, rate, saturation


def _refined(blocks: Blocks, point: Array) -> Array:
    """The least-squares (dead time, rate, saturation) near `point`: a lattice that moves, and shrinks when it stays."""
    _, rate, saturation = point
    step = np.array([max(0.05, blocks.period_s), 0.25 * rate, 0.03 * saturation])
    lattice = np.array(np.meshgrid([-1, 0, 1], [-1, 0, 1], [-1, 0, 1])).reshape(3, -1).T
    centre, halvings = len(lattice) // 2, 0
    while halvings < _HALVINGS:
        tried = point + lattice * step
        tried[:, 0] = np.clip(tried[:, 0], 0.0, _LONGEST_DEAD_TIME_S)
        tried[:, 1:] = np.maximum(tried[:, 1:], 1e-6)
        power = blocks.power(*tried.T)
        best = int(np.argmin(power))
        if power[best] < power[centre]:
            point = tried[best]
        else:
            step = 0.5 * step
            halvings += 1
    return point


def _best_dead_time(blocks: Blocks, near_s: float, rate: float, saturation: float) -> float:
    """The best dead time for these limits, found on ever finer grids about `near_s`."""
    width = 0.3
    for _ in range(3):
        tried = np.clip(near_s + width * np.linspace(-1.0, 1.0, 25), 0.0, _LONGEST_DEAD_TIME_S)
        power = blocks.power(tried, np.full(25, rate), np.full(25, saturation))
        near_s = float(np.mean(tried[power <= power.min() * (1.0 + 1e-12)]))
        width /= 8.0
    return near_s


def _slew_rate(blocks: Blocks, model: ActuatorModel) -> tuple[float, float] | None:
    """Median of the mean speeds over the middle of the long slews, and its standard deviation; None if there is none.

    Long: 6 rows, and half as long as the longest; the middle: two fifths of it. The median leaves out slews that the
    real actuator did not make as the model does.
    """
    speed = np.diff(blocks.run(model), axis=0, prepend=0.0) / blocks.period_s
    least = model.rate_limit_per_s * (1.0 - 1e-6)
    slews = [(part, block) for limiting in (blocks.used & (speed >= least), blocks.used & (speed <= -least))
             for block in range(limiting.shape[1]) for part in stretches(limiting[:, block], 6)]
    longest = max((part.stop - part.start for part, _ in slews), default=0)
    speeds = []
    for part, block in slews:
        rows = part.stop - part.start
        if rows >= 0.5 * longest:
            first, last = part.start + round(0.3 * rows), part.start + round(0.7 * rows)
            way = abs(blocks.measured[last, block] - blocks.measured[first, block])
            speeds.append(way / ((last - first) * blocks.period_s))
    if not speeds:
        return None
    rate = float(np.median(speeds))
    # A median's standard deviation, with that of the speeds from their median absolute deviation: 1.2533 * 1.4826.
    return rate, 1.858 * float(np.median(np.abs(np.array(speeds) - rate))) / len(speeds) ** 0.5


def _residual(blocks: Blocks, model: ActuatorModel) -> Array:
    """Recorded less model position, of all used rows, block after block."""
    return (blocks.measured - blocks.run(model)).T[blocks.used.T]


def _stds(blocks: Blocks, model: ActuatorModel, residual: Array, unknowns: list[tuple[str, float]]
          ) -> dict[str, float]:
    """Standard deviations of the model's settings; `unknowns` are their names and steps of differentiation."""
    columns = []
    for name, step in unknowns:
        value = getattr(model, name)
        low = max(0.0, value - step)
        below, above = (_residual(blocks, model._replace(**{name: side})) for side in (low, value + step))
        columns.append((below - above) / (value + step - low))
    std = blocked_std(np.column_stack(columns), residual, round(_BLOCK_S / blocks.period_s))
    return {name: float(value) for (name, _), value in zip(unknowns, std, strict=True)}
