"""A log as arrays: the flight at the times of its state messages, delays, and link quality."""

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

_ONE_CLOCK_S = 2.0  # ages below this are believed: independent clocks rarely agree so well
_DRIFT_S = 60.0  # the drift of clocks over this time is too small for a plot to show
_STEP_S = 1.0


class Delays(NamedTuple):
    """Delays over a flight [s], each with the times [s] at which they were observed.

    `round_trip_s`: of TIMESYNC, ground station to vehicle and back. `telemetry_s`: of a state message on its way down,
    in excess of the minimum of that minute, as the two clocks have no common start. `sample_age_s`: age of the sample
    that a tick used, likewise in excess of its minimum unless `absolute_age`.
    """

    round_trip_at_s: Array
    round_trip_s: Array
    state_at_s: Array
    telemetry_s: Array
    sample_age_s: Array
    absolute_age: bool


class LinkQuality(NamedTuple):
    """Quality of a link, (n,) each: times [s], loss as a fraction, messages per second [1/s]."""

    time_s: Array
    loss: Array
    rate_hz: Array


def recorded_flight(log: MessageLog, vehicle: Address) -> FlightRecord:
    """The flight, with a row for each state message, in the order in which the vehicle sent them.

    `time_s` counts from the log's start: when the message would have arrived with the minimum delay of that minute. In
    `further`: `received_s`, when it arrived; `vehicle_time_s`, the vehicle's clock from the first state on; `armed`, 0
    or 1 by the last heartbeat, NaN before the first.
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
    """The delays in a log, whose recorded flight is `flight`."""
    received_s, age_s = flight.further["received_s"], flight.sample_age_s
    absolute = bool(age_s.size) and age_s.min() >= 0.0 and age_s.max() < _ONE_CLOCK_S
    if not absolute:
        age_s = np.maximum(age_s - _least(received_s, age_s), 0.0)
    return Delays(*_round_trips(log, vehicle), flight.time_s, np.maximum(received_s - flight.time_s, 0.0),
                  age_s, absolute)


def link_quality(log: MessageLog, vehicle: Address) -> LinkQuality:
    """Quality of the link from the vehicle, over the 5 s before each time.

    Loss is what is missing from the sequence numbers; NaN if nothing arrived for 5 s, and in a log of the control path
    (with samples), from which the bridge omits some of the vehicle's messages.
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
    """The running minimum of `values`: the minima of stretches of _DRIFT_S, interpolated."""
    stretch = np.floor((time_s - time_s[:1]) / _DRIFT_S)
    numbers = np.unique(stretch)
    at_s = [float(time_s[stretch == number].mean()) for number in numbers]
    return np.interp(time_s, at_s, [float(values[stretch == number].min()) for number in numbers]) if at_s else values


def _on_the_logs_clock(received_s: Array, vehicle_s: Array) -> Array:
    """When the vehicle sent what arrived at `received_s` [s], plus the minimum delay.

    If its clock runs at another rate, as in a replay at another speed, the time of arrival is used.
    """
    if received_s.size and abs(np.ptp(received_s) - np.ptp(vehicle_s)) > 1.0 + 0.01 * np.ptp(received_s):
        return received_s
    return np.minimum(vehicle_s + _least(received_s, received_s - vehicle_s), received_s)


def _round_trips(log: MessageLog, vehicle: Address) -> tuple[Array, Array]:
    """When TIMESYNC answers arrived, and how long after their questions [s].

    A question in the log, with the asker's clock in ts1, gives the offset between that clock and the log's; the answers
    repeat ts1. With several askers, the answer is taken to be for the one with the shortest non-negative time.
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
