"""From a log to arrays: the flight at the times of its state messages, and how the links did meanwhile."""

from typing import NamedTuple

import numpy as np

from ground.link.connection import Address
from ground.link.statistics import LinkStatistics
from ground.logs.reader import FlightLog, Logged
from ground.vehicle.state import is_armed
from kite_analysis.figure_eight import Array, wrap
from protocol import dialect

CLOCK_WRAP_US = 1 << 30  # of the firmware's clock, and of the sensors'
_ONE_CLOCK_S = 2.0  # ages below this are taken as such; two clocks of their own seldom agree so well
_DRIFT_S = 60.0  # over this long, clocks do not drift apart by anything that a plot shows
_MOST_DELAY_S = 5.0
_STEP_S = 1.0
# Column: field of KITE_STATE, and the validity bit without which it was not measured.
_MEASURED = {
    "azimuth_rad": ("azimuth", 0), "elevation_rad": ("elevation", 0), "distance_m": ("distance", 0),
    "course_rad": ("course", 0), "target_course_rad": ("target_course", 0), "heading_rad": ("heading", 0),
    "cross_track_rad": ("cross_track", 0), "path_parameter_rad": ("path_parameter", 0),
    "steering_asked": ("steering_asked", 0), "steering": ("steering", dialect.KITE_VALID_STEERING),
    "airspeed_m_s": ("airspeed", 0), "tether_force_n": ("tether_force", dialect.KITE_VALID_TETHER_FORCE),
}
_COUNTED = ("status", "valid", "tick_us", "tick_worst_us", "overruns", "samples_dropped")


class Delays(NamedTuple):
    """Delays over a flight, each with the times [s] at which they were seen.

    `round_trip_s`: of TIMESYNC, ground station to vehicle and back. `telemetry_s`: a state message's way down, above
    the least of some minute, as the two clocks have no common start. `sample_age_s`: how old the sample was that a tick
    used, measured likewise unless `absolute_age`.
    """

    round_trip_at_s: Array
    round_trip_s: Array
    state_at_s: Array
    telemetry_s: Array
    sample_age_s: Array
    absolute_age: bool


def flight_table(log: FlightLog, vehicle: Address) -> dict[str, Array]:
    """Columns (n,) of a flight by name, at its n state messages; angles in radians, NaN where not measured.

    The rows are in the vehicle's order, whichever way the messages overtook each other. `time_s` counts from the log's
    start; it is when the message would have come with no more delay than the least of the time. `received_s` is when
    it came, `vehicle_time_s` the vehicle's own clock, counted from the first state. `mode` and `status` are the numbers
    of KITE_MODE and KITE_STATUS; `armed` is 0 or 1, as the last heartbeat told, or NaN before the first.
    """
    states, armed, last = [], [], np.nan
    for entry in log.of(vehicle):
        if isinstance(entry.message, dialect.MAVLink_heartbeat_message):
            last = float(is_armed(entry.message))
        elif isinstance(entry.message, dialect.MAVLink_kite_state_message):
            states.append(entry)
            armed.append(last)
    valid = _field(states, "valid").astype(int)
    received_s = _received(states)
    vehicle_s = unwrap_clock(_field(states, "time_us"), received_s)
    columns = {"time_s": _on_the_logs_clock(received_s, vehicle_s), "received_s": received_s,
               "vehicle_time_s": vehicle_s, "mode": _field(states, "mode"), "armed": np.array(armed)}
    for name, (field, bit) in _MEASURED.items():
        values = _field(states, field)
        columns[name] = np.where(valid & bit, values, np.nan) if bit else values
    columns["course_error_rad"] = wrap(columns["target_course_rad"] - columns["course_rad"])
    for name in _COUNTED:
        columns[name] = _field(states, name)
    order = np.argsort(vehicle_s, kind="stable")
    columns = {name: values[order] for name, values in columns.items()}
    return columns | {"time_s": np.maximum.accumulate(columns["time_s"])}


def delays(log: FlightLog, vehicle: Address) -> Delays:
    """The delays that a log tells of."""
    states = [entry for entry in log.of(vehicle) if isinstance(entry.message, dialect.MAVLink_kite_state_message)]
    received_s = _received(states)
    vehicle_s = unwrap_clock(_field(states, "time_us"), received_s)
    time_s = _on_the_logs_clock(received_s, vehicle_s)
    order = np.argsort(vehicle_s, kind="stable")
    age_us = _field(states, "time_us") - _field(states, "sample_time_us")
    age_s = (np.cumsum(_signed_us(np.diff(age_us, prepend=age_us[:1]))) + _signed_us(age_us[:1])) * 1e-6
    absolute = bool(age_s.size) and age_s.min() >= 0.0 and age_s.max() < _ONE_CLOCK_S
    if not absolute:
        age_s = np.maximum(age_s - _least(received_s, age_s), 0.0)
    return Delays(*_round_trips(log, vehicle), time_s[order], (received_s - time_s)[order], age_s[order], absolute)


def link_quality(log: FlightLog, vehicle: Address) -> tuple[Array, Array, Array]:
    """Times [s], share of the vehicle's messages lost (0 to 1), and messages a second, over the 5 s before each.

    Lost is what is missing from the sequence numbers. Where nothing came for 5 s, the share is NaN; so it is in a log
    of the control side, with the sensors' samples: the bridge writes it without some of what the vehicle sent.
    """
    statistics, rows = LinkStatistics(), []
    control_side = any(isinstance(entry.message, dialect.MAVLink_kite_sensors_message) for entry in log.messages)
    due_s = None
    for entry in log.of(vehicle):
        due_s = entry.time_s + _STEP_S if due_s is None else due_s
        while due_s < entry.time_s:
            rows.append(_quality(statistics, due_s))
            due_s += _STEP_S
        statistics.add(entry.time_s, entry.sequence, entry.sender.component)
    times, loss, rate = np.array(rows or np.empty((0, 3))).T
    return times, np.full_like(loss, np.nan) if control_side else loss, rate


def unwrap_clock(time_us: Array, received_s: Array) -> Array:
    """Seconds since the first of these readings [us] of a clock that wraps at CLOCK_WRAP_US.

    Where it and the times at which they came [s] disagree by more than a link delays, the vehicle has started anew, or
    was silent for longer than a turn of the clock: there the latter count.
    """
    steps_s = _signed_us(np.diff(time_us)) * 1e-6
    came_s = np.diff(received_s)
    steps_s = np.where(np.abs(steps_s - came_s) < _MOST_DELAY_S, steps_s, came_s)
    return np.concatenate([[0.0], np.cumsum(steps_s)])[: len(time_us)]


def _signed_us(difference_us: Array) -> Array:
    """Differences of wrapping clocks [us], brought nearest to zero."""
    return (difference_us + CLOCK_WRAP_US // 2) % CLOCK_WRAP_US - CLOCK_WRAP_US // 2


def _field(states: list[Logged], name: str) -> Array:
    return np.array([getattr(entry.message, name) for entry in states], dtype=float)


def _received(states: list[Logged]) -> Array:
    return np.array([entry.time_s for entry in states], dtype=float)


def _least(time_s: Array, values: Array) -> Array:
    """The least of `values` around each time, over some _DRIFT_S: from the least of each such stretch to the next."""
    stretch = np.floor((time_s - time_s[:1]) / _DRIFT_S)
    numbers = np.unique(stretch)
    at_s = [float(time_s[stretch == number].mean()) for number in numbers]
    return np.interp(time_s, at_s, [float(values[stretch == number].min()) for number in numbers]) if at_s else values


def _on_the_logs_clock(received_s: Array, vehicle_s: Array) -> Array:
    """When the vehicle sent what came at `received_s`, but for the least delay.

    A vehicle whose clock runs at another rate is a replay of another speed: there, when it came is all that counts.
    """
    if received_s.size and abs(np.ptp(received_s) - np.ptp(vehicle_s)) > 1.0 + 0.01 * np.ptp(received_s):
        return received_s
    return np.minimum(vehicle_s + _least(received_s, received_s - vehicle_s), received_s)


def _round_trips(log: FlightLog, vehicle: Address) -> tuple[Array, Array]:
    """When TIMESYNC answers came and how long after their questions.

    A question in the log (with ts1, the asker's clock) says how that clock and the log's compare; the answers repeat
    ts1. Of several askers' clocks, the one that gives the shortest time that is possible is the answer's.
    """
    offsets: dict[Address, float] = {}
    found = []
    for entry in log.messages:
        message = entry.message
        if not isinstance(message, dialect.MAVLink_timesync_message):
            continue
        asked_s = message.ts1 * 1e-9
        if message.tc1 == 0:
            offset_s = entry.time_s - asked_s
            offsets[entry.sender] = min(offset_s, offsets.get(entry.sender, offset_s))
        elif entry.sender == vehicle:
            taken = [entry.time_s - asked_s - offset_s for offset_s in offsets.values()]
            taken = [seconds for seconds in taken if 0.0 <= seconds < _DRIFT_S]
            if taken:
                found.append((entry.time_s, min(taken)))
    times, taken_s = np.array(found or np.empty((0, 2))).T
    return times, taken_s


def _quality(statistics: LinkStatistics, now_s: float) -> tuple[float, float, float]:
    loss = statistics.loss(now_s)
    return now_s, np.nan if loss is None else loss, statistics.rate_hz(now_s)
