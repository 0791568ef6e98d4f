"""From a log to arrays: the flight at the times of its state messages, and how the links did meanwhile."""

from typing import NamedTuple

import numpy as np

from ground.link.statistics import LinkStatistics
from ground.logs.reader import MessageLog
from ground.vehicle.state import is_armed
from kite_analysis.figure_eight import Array
from kite_analysis.flights.record import FlightRecord
from kite_analysis.flights.telemetry import fields_of, record_of_states
from protocol import dialect
from protocol.clock import ages_s, counted_on
from protocol.frame import Address

_ONE_CLOCK_S = 2.0  # ages below this are taken as such; two clocks of their own seldom agree so well
_DRIFT_S = 60.0  # over this long, clocks do not drift apart by anything that a plot shows
_STEP_S = 1.0


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


class LinkQuality(NamedTuple):
    """How a link did, (n,) each: times [s], share of the messages lost (0 to 1), and messages a second."""

    time_s: Array
    loss: Array
    rate_hz: Array


def recorded_flight(log: MessageLog, vehicle: Address) -> FlightRecord:
    """The flight, with a row for each state message.

    The rows are in the vehicle's order, whichever way the messages overtook each other. `time_s` counts from the log's
    start; it is when the message would have come with no more delay than the least of the time. Of what there is
    further, `received_s` is when it came, `vehicle_time_s` the vehicle's own clock, counted from the first state, and
    `armed` is 0 or 1, as the last heartbeat told, or NaN before the first.
    """
    states, armed, last = [], [], np.nan
    for entry in log.of(vehicle):
        if isinstance(entry.message, dialect.MAVLink_heartbeat_message):
            last = float(is_armed(entry.message))
        elif isinstance(entry.message, dialect.MAVLink_kite_state_message):
            states.append(entry)
            armed.append(last)
    fields = fields_of([entry.message for entry in states], dialect.MAVLink_kite_state_message)
    received_s = np.array([entry.time_s for entry in states], dtype=float)
    vehicle_s = np.array(counted_on(fields["time_us"], received_s))
    age_s = np.array(ages_s(fields["time_us"], fields["sample_time_us"]))
    further = {"received_s": received_s, "vehicle_time_s": vehicle_s, "armed": np.array(armed)}
    flight = record_of_states(fields, _on_the_logs_clock(received_s, vehicle_s), age_s, log.path.name, further)
    flight = flight.rows(np.argsort(vehicle_s, kind="stable"))
    return flight._replace(time_s=np.maximum.accumulate(flight.time_s))


def delays(log: MessageLog, vehicle: Address, flight: FlightRecord) -> Delays:
    """The delays that a log and the `flight` in it tell of."""
    received_s, age_s = flight.further["received_s"], flight.sample_age_s
    absolute = bool(age_s.size) and age_s.min() >= 0.0 and age_s.max() < _ONE_CLOCK_S
    if not absolute:
        age_s = np.maximum(age_s - _least(received_s, age_s), 0.0)
    return Delays(*_round_trips(log, vehicle), flight.time_s, np.maximum(received_s - flight.time_s, 0.0),
                  age_s, absolute)


def link_quality(log: MessageLog, vehicle: Address) -> LinkQuality:
    """How the link from the vehicle did, over the 5 s before each time.

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
        statistics.add(entry.time_s, entry.header.sequence, entry.sender.component)
    times, loss, rate = np.array(rows or np.empty((0, 3))).T
    return LinkQuality(times, np.full_like(loss, np.nan) if control_side else loss, rate)


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


def _round_trips(log: MessageLog, vehicle: Address) -> tuple[Array, Array]:
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
