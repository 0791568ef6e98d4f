"""A recorded tlog as a flight for identification: KITE_STATE, and KITE_SENSORS where there are more of them."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from kite_analysis.flights.columns import QUANTITIES, FlightDataError
from kite_analysis.flights.record import FlightRecord, Series, make_record
from kite_analysis.figure_eight import Array
from kite_analysis.flights.tlog import read_tlog
from protocol import dialect

_WRAP_US = 1 << 30
_SMOOTHING_S = 0.3
_SAME_CLOCK_S = 2.0
_EVERY_TICK_S = 0.03  # messages that come more often than this are those of every tick of the control loop
_BITS = {
    "azimuth": dialect.KITE_VALID_AZIMUTH, "elevation": dialect.KITE_VALID_ELEVATION,
    "course": dialect.KITE_VALID_COURSE, "heading": dialect.KITE_VALID_HEADING,
    "airspeed": dialect.KITE_VALID_AIRSPEED, "distance": dialect.KITE_VALID_DISTANCE,
    "steering": dialect.KITE_VALID_STEERING,
}


def read_tlog_record(path: Path, on_the_sensors_clock: bool = False) -> FlightRecord:
    """The flight of the first kite in the tlog at `path`; rows in STANDBY are not selected.

    Rows lie at the times of the commands, on the firmware's clock where it is that of the sensors too, else (and always
    if `on_the_sensors_clock`) earlier by the usual age of a sample: a delay found from them has that age in it, and the
    two clocks need not agree. A course that was not measured is taken as the firmware found it.

    Raises:
        FlightDataError: it cannot be read, or holds no kite.
    """
    states, sensors = _messages(path)
    from_states = len(states) >= len(sensors)
    series, rows_s = _samples(states if from_states else sensors, from_states)
    later = np.empty(0, dtype=bool)
    if states:
        asked_s = _command_times(states, on_the_sensors_clock)
        later = _newer(asked_s)
        rows_s = asked_s[later]
        asked = np.array([message.steering_asked for _, message in states], dtype=float)
        series["set_steering"] = Series(rows_s, asked[later], QUANTITIES["set_steering"][1])
    if len(rows_s) < 2:
        raise FlightDataError(f"{path}: no two KITE_STATE or KITE_SENSORS of different times in this tlog")
    record = make_record(series, rows_s, path.name, "", _SMOOTHING_S, smooth_both=True)
    if states:
        flying = np.array([message.mode != dialect.KITE_MODE_STANDBY for _, message in states])[later]
        row = np.clip(np.searchsorted(rows_s, record.time_s + 0.01 * record.period_s, "right") - 1, 0, None)
        record = record._replace(selected=flying[row])
    record = record._replace(time_s=record.time_s - rows_s[0])
    return record if record.period_s < _EVERY_TICK_S else _between_messages(record)


def _samples(messages: list[tuple[int, Any]], from_states: bool) -> tuple[dict[str, Series], Array]:
    """What was measured, and when [s]."""
    if not messages:
        return {}, np.empty(0)
    time_s = _seconds(messages, "sample_time_us" if from_states else "time_us")
    new = _newer(time_s)
    valid = np.array([message.valid for _, message in messages])
    series = {}
    for quantity, bit in _BITS.items():
        values = np.array([getattr(message, quantity) for _, message in messages], dtype=float)
        known = (valid & bit > 0) | (from_states and quantity == "course")
        series[quantity] = Series(time_s[new], np.where(known, values, np.nan)[new], QUANTITIES[quantity][1])
    return series, time_s[new]


def _between_messages(record: FlightRecord) -> FlightRecord:
    """Messages come less often than commands: between two of them the command is, on average, the mean of both."""
    following = np.append(record.set_steering[1:], record.set_steering[-1])
    return record._replace(set_steering=0.5 * (record.set_steering + following), command_slack_s=record.period_s)


def _newer(time_s: Array) -> Array:
    """True where a time [s] (n,) is later than all before it."""
    return np.concatenate([[True], np.diff(np.maximum.accumulate(time_s)) > 0.0])


def _messages(path: Path) -> tuple[list[tuple[int, Any]], list[tuple[int, Any]]]:
    """(microseconds of the recorder, message) of the first kite: KITE_STATE, KITE_SENSORS."""
    found: dict[int, list[tuple[int, Any]]] = {
        dialect.MAVLINK_MSG_ID_KITE_STATE: [], dialect.MAVLINK_MSG_ID_KITE_SENSORS: []}
    system: dict[int, int] = {}
    for stamp_us, message in _decoded(path, set(found)):
        kind = message.get_msgId()
        if system.setdefault(kind, message.get_srcSystem()) == message.get_srcSystem():
            found[kind].append((stamp_us, message))
    return found[dialect.MAVLINK_MSG_ID_KITE_STATE], found[dialect.MAVLINK_MSG_ID_KITE_SENSORS]


def _decoded(path: Path, kinds: set[int]) -> Iterator[tuple[int, Any]]:
    parser = dialect.MAVLink(None)
    parser.robust_parsing = True
    try:
        for stamp_us, frame in read_tlog(path):
            if frame[0] == dialect.PROTOCOL_MARKER_V2 and int.from_bytes(frame[7:10], "little") in kinds:
                for message in parser.parse_buffer(frame) or []:
                    if message.get_msgId() in kinds:
                        yield stamp_us, message
    except OSError as error:
        raise FlightDataError(f"{path}: {error.strerror}") from error
    except ValueError as error:
        raise FlightDataError(str(error)) from error


def _command_times(states: list[tuple[int, Any]], on_the_sensors_clock: bool) -> Array:
    """When the commands were given [s], on the clock of the samples; see `read_tlog_record`."""
    given_s, sampled_s = _seconds(states, "time_us"), _seconds(states, "sample_time_us")
    age_s = float(np.median(given_s - sampled_s))
    one_clock = 0.0 <= age_s % (_WRAP_US * 1e-6) < _SAME_CLOCK_S
    return given_s if one_clock and not on_the_sensors_clock else given_s - age_s


def _seconds(messages: list[tuple[int, Any]], field: str) -> Array:
    """Times [s] of a clock that wraps at 2^30 us; the recorder's own clock says how often it did."""
    stamp_us = np.array([stamp for stamp, _ in messages], dtype=np.int64)
    clock_us = np.array([getattr(message, field) for _, message in messages], dtype=np.int64)
    ahead_us = stamp_us - clock_us
    wraps = np.round((ahead_us - ahead_us[0]) / _WRAP_US).astype(np.int64)
    return (clock_us + wraps * _WRAP_US) * 1e-6
