"""What a kite tells of its flight, KITE_STATE by KITE_STATE, as a recorded flight; live and from a tlog alike."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from kite_analysis.figure_eight import Array
from kite_analysis.flights.description import QUANTITIES, FlightDataError
from kite_analysis.flights.record import COLUMNS, FlightRecord, Series, as_recorded, on_a_grid
from kite_analysis.flights.tlog import read_tlog
from protocol import dialect
from protocol.clock import ages_s, counted_on, nearest_us
from protocol.frame import read_header

_SMOOTHING_S = 0.3
_SAME_CLOCK_S = 2.0
_EVERY_TICK_S = 0.03  # messages that come more often than this are those of every tick of the control loop
_BITS = {
    "azimuth": dialect.KITE_VALID_AZIMUTH, "elevation": dialect.KITE_VALID_ELEVATION,
    "course": dialect.KITE_VALID_COURSE, "heading": dialect.KITE_VALID_HEADING,
    "airspeed": dialect.KITE_VALID_AIRSPEED, "distance": dialect.KITE_VALID_DISTANCE,
    "tether_force": dialect.KITE_VALID_TETHER_FORCE, "steering": dialect.KITE_VALID_STEERING,
}
_TOO_FEW = "no two KITE_STATE or KITE_SENSORS of different times"
_NOT_ESTIMATED = ("steering", "tether_force")  # KITE_STATE's others are what the controller takes for true


class Heard(NamedTuple):
    """A message, and when it came by the recorder's clock [s]."""

    time_s: float
    message: Any


def fields_of(messages: Sequence[Any], kind: type[dialect.MAVLink_message]) -> dict[str, Array]:
    """The fields of `messages`, all of this kind, by name, (n,) each."""
    return {name: np.array([getattr(message, name) for message in messages], dtype=float)
            for name in kind.ordered_fieldnames}


def record_of_states(fields: Mapping[str, Array], time_s: Array, sample_age_s: Array, title: str = "",
                     further: Mapping[str, Array] | None = None) -> FlightRecord:
    """A flight with a row for each KITE_STATE, whose `fields` these are, at the times (n,) [s] of the ticks.

    Quantities are as the controller had them, measured or not, as `further["valid"]` says; steering and tether force
    that were not measured are missing. Rows in STANDBY are not selected.
    """
    valid = fields["valid"].astype(int)
    columns = {name: values for name, values in fields.items() if name in COLUMNS}
    columns |= {name: np.where(valid & _BITS[name], fields[name], np.nan) for name in _NOT_ESTIMATED}
    columns |= {"set_steering": fields["steering_asked"], "sample_age_s": sample_age_s}
    others = {name: values for name, values in fields.items() if name not in COLUMNS and name != "steering_asked"}
    return as_recorded(time_s, columns, title, smoothing_s=_SMOOTHING_S,
                       selected=fields["mode"] != dialect.KITE_MODE_STANDBY, further=others | dict(further or {}))


def read_tlog_record(path: Path) -> FlightRecord:
    """The flight of the first kite in the tlog at `path`: KITE_STATE, or KITE_SENSORS where there are more of them.

    Raises:
        FlightDataError: it cannot be read, or holds no kite.
    """
    states, sensors = _messages(path)
    try:
        return _from_states(states, sensors, path.name) if states else _from_sensors(sensors, path.name)
    except FlightDataError as error:
        raise FlightDataError(f"{path}: {error}") from error


def for_identification(flight: FlightRecord, on_the_sensors_clock: bool = False,
                       measured: Mapping[str, Series] | None = None) -> FlightRecord:
    """A `flight` as of `record_of_states` on a uniform grid, with what was measured, at the times of the samples.

    Rows lie at the times of the steering commands, on the firmware's clock where it is that of the sensors too, else
    (and always if `on_the_sensors_clock`) earlier by the usual age of a sample: a delay found from them includes that
    age, and the two clocks need not agree. A course that was not measured is taken as the firmware found it. `measured`
    replaces what the states say of the samples.

    Raises:
        FlightDataError: there are no two rows of different times, or too many are missing.
    """
    if not len(flight.time_s):
        raise FlightDataError(_TOO_FEW)
    age_s = float(np.median(flight.sample_age_s))
    one_clock = 0.0 <= age_s < _SAME_CLOCK_S and not on_the_sensors_clock
    asked_s = flight.time_s if one_clock else flight.time_s - age_s
    later = _newer(asked_s)
    series = dict(measured or _measured_by_states(flight))
    series["set_steering"] = Series(asked_s[later], flight.set_steering[later], _longest_gap_s("set_steering"))
    return _evenly_spaced(series, flight.rows(later)._replace(time_s=asked_s[later]))


def _measured_by_states(flight: FlightRecord) -> dict[str, Series]:
    """The samples that the states tell of; before the first one their time means nothing."""
    flight = flight.rows(flight.further["valid"] > 0)
    flight = flight._replace(time_s=flight.time_s - flight.sample_age_s)
    flight = flight.rows(_newer(flight.time_s))
    valid = flight.further["valid"].astype(int)
    return {quantity: Series(flight.time_s,
                             np.where((valid & bit > 0) | (quantity == "course"), getattr(flight, quantity), np.nan),
                             _longest_gap_s(quantity)) for quantity, bit in _BITS.items()}


def _measured_by_sensors(sensors: list[Heard], begin_s: float) -> dict[str, Series]:
    """The samples themselves, the first of them at `begin_s` [s]."""
    fields = fields_of([heard.message for heard in sensors], dialect.MAVLink_kite_sensors_message)
    time_s = begin_s + np.array(counted_on(fields["time_us"], (heard.time_s for heard in sensors)))
    new = _newer(time_s)
    valid = fields["valid"].astype(int)
    return {quantity: Series(time_s[new], np.where(valid & bit > 0, fields[quantity], np.nan)[new],
                             _longest_gap_s(quantity)) for quantity, bit in _BITS.items()}


def _from_states(states: list[Heard], sensors: list[Heard], title: str) -> FlightRecord:
    """A flight that the states tell of, with the samples themselves where there are more of them."""
    fields = fields_of([heard.message for heard in states], dialect.MAVLink_kite_state_message)
    time_s = np.array(counted_on(fields["time_us"], (heard.time_s for heard in states)))
    age_s = np.array(ages_s(fields["time_us"], fields["sample_time_us"]))
    flight = record_of_states(fields, time_s, age_s, title)
    if len(sensors) <= len(states):
        return for_identification(flight)
    last, first = states[-1], sensors[0]
    expected_us = round((first.time_s - last.time_s) * 1e6)
    apart_us = nearest_us(first.message.time_us - last.message.sample_time_us, expected_us)
    begin_s = time_s[-1] - age_s[-1] + apart_us * 1e-6
    return for_identification(flight, measured=_measured_by_sensors(sensors, begin_s))


def _from_sensors(sensors: list[Heard], title: str) -> FlightRecord:
    """A flight of which only the samples are known."""
    if not sensors:
        raise FlightDataError(_TOO_FEW)
    series = _measured_by_sensors(sensors, 0.0)
    return _evenly_spaced(series, as_recorded(series["azimuth"].time_s, {}, title, smoothing_s=_SMOOTHING_S))


def _evenly_spaced(series: Mapping[str, Series], flight: FlightRecord) -> FlightRecord:
    """On a grid whose time begins with 0; steering commands of messages that come less often are means."""
    if len(flight.time_s) < 2:
        raise FlightDataError(_TOO_FEW)
    record = on_a_grid(series, flight)
    record = record._replace(time_s=record.time_s - flight.time_s[0])
    return record if record.period_s < _EVERY_TICK_S else _between_messages(record)


def _between_messages(record: FlightRecord) -> FlightRecord:
    """With fewer messages than steering commands: between two messages, the steering is on average the mean of both."""
    following = np.append(record.set_steering[1:], record.set_steering[-1])
    return record._replace(set_steering=0.5 * (record.set_steering + following), command_slack_s=record.period_s)


def _newer(time_s: Array) -> Array:
    """True where a time [s] (n,) is later than all before it."""
    return np.diff(np.maximum.accumulate(time_s), prepend=-np.inf) > 0.0


def _longest_gap_s(quantity: str) -> float:
    _, gap_s = QUANTITIES[quantity]
    return gap_s


def _messages(path: Path) -> tuple[list[Heard], list[Heard]]:
    """What the first kite told: KITE_STATE, KITE_SENSORS."""
    found: dict[int, list[Heard]] = {dialect.MAVLINK_MSG_ID_KITE_STATE: [], dialect.MAVLINK_MSG_ID_KITE_SENSORS: []}
    system: dict[int, int] = {}
    for heard in _decoded(path, set(found)):
        kind = heard.message.get_msgId()
        if system.setdefault(kind, heard.message.get_srcSystem()) == heard.message.get_srcSystem():
            found[kind].append(heard)
    return found[dialect.MAVLINK_MSG_ID_KITE_STATE], found[dialect.MAVLINK_MSG_ID_KITE_SENSORS]


def _decoded(path: Path, kinds: set[int]) -> Iterator[Heard]:
    parser = dialect.MAVLink(None)
    parser.robust_parsing = True
    try:
        for stamp_us, frame in read_tlog(path):
            if read_header(frame).message in kinds:
                for message in parser.parse_buffer(frame) or []:
                    if message.get_msgId() in kinds:
                        yield Heard(stamp_us * 1e-6, message)
    except OSError as error:
        raise FlightDataError(f"{path}: {error.strerror}") from error
    except ValueError as error:
        raise FlightDataError(str(error)) from error
