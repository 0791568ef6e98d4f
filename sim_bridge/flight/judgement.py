"""How the bridge judges a flight: from the true position, and from messages that cannot be turned off.

The mode comes from HEARTBEAT, the steering asked for from the steering frames, the eight and the limits from
PARAM_VALUE: the firmware sends all three whatever ground stations ask for. KITE_STATE, which they can turn off, is not
looked at.
"""

from math import inf
from typing import Any, Final

import numpy as np

from kite_analysis.angles import wrap
from kite_analysis.eight_following import follow_eight
from kite_analysis.figure_eight import Array, TargetEight, unit_position
from kite_analysis.metrics import Track
from protocol import dialect
from protocol.messages import ParamValue
from sim_bridge.runtimes.tick_output import TickOutput
from sim_bridge.scenario.scenario import Scenario

MODE_UNKNOWN: Final = -1
_SILENCE_S: Final = 3.0  # without a heartbeat nobody knows the mode
_AT_LIMIT: Final = 1.0 - 1e-6
_YARDSTICK = (
    "EIGHT_AZIMUTH", "EIGHT_ELEVATION", "EIGHT_HALF_W", "EIGHT_HALF_H", "EIGHT_DIRECTION",
    "OUTER_L", "GAIN_TAU", "GAIN_L_TAU", "LOOP_HZ", "STEER_MAX")
_GREATEST_GAIN: Final = 50.0

Columns = dict[str, Array]


class Judge:
    """Records the commanded steering, tick by tick; `steering_asked` is the newest."""

    def __init__(self, scenario: Scenario):
        self.steering_asked = 0.0
        self._mode = MODE_UNKNOWN
        self._heard_s = -inf
        self._reach = scenario.actuator.reach
        self._parts = [(0, {name: scenario.parameter(name) for name in _YARDSTICK})]  # from which row on

    def hear(self, time_s: float, output: TickOutput, row: int) -> None:
        """Take what came out of the tick at `time_s`, whose truth is row number `row`."""
        if output.mode is not None:
            self._mode, self._heard_s = output.mode, time_s
        if output.steering:
            _, self.steering_asked = output.steering[-1]
        for _, reply in output.replies:
            if isinstance(reply, ParamValue):
                self._follow(reply.param_id.rstrip(b"\0").decode(errors="replace"), reply.param_value, row)

    def mode(self, time_s: float) -> int:
        """The mode at `time_s`, MODE_UNKNOWN if the firmware has long been silent."""
        return self._mode if time_s - self._heard_s <= _SILENCE_S else MODE_UNKNOWN

    def track(self, columns: Columns, first: int = 0) -> Track:
        """Truth by column, from row number `first` of the flight on, as a track. There must be a row at least."""
        starts = [max(0, row - first) for row, _ in self._parts]
        ends = [*starts[1:], len(columns["time_s"])]
        parts = [
            self._part({name: values[start:end] for name, values in columns.items()}, parameters)
            for start, end, (_, parameters) in zip(starts, ends, self._parts, strict=True) if start < end]
        fields = [np.concatenate(values) for values in zip(*(part[:-1] for part in parts), strict=True)]
        return Track._make((*fields, parts[-1].half_width))

    def _part(self, columns: Columns, parameters: dict[str, float]) -> Track:
        """Rows during which the parameters were the same."""
        eight = TargetEight.from_parameters(parameters.__getitem__)
        azimuth, elevation, course = columns["azimuth_rad"], columns["elevation_rad"], columns["course_rad"]
        target, cross_track = follow_eight(
            eight, unit_position(azimuth, elevation), course, _outer_gain(columns, parameters))
        at_limit = np.abs(columns["steering_asked"]) >= parameters["STEER_MAX"] * _AT_LIMIT
        at_limit |= np.abs(columns["steering"]) >= self._reach * _AT_LIMIT
        return Track(
            columns["time_s"], azimuth, elevation, course, target, cross_track, columns["steering"],
            columns["steering_asked"], columns["tether_force_n"], at_limit.astype(float),
            (columns["mode"] == dialect.KITE_MODE_TRACK).astype(float), eight.half_width)

    def _follow(self, name: str, value: float, row: int) -> None:
        """A parameter has this value from now on."""
        begin, parameters = self._parts[-1]
        if parameters.get(name, value) == value:
            return
        if begin == row:
            self._parts.pop()
        self._parts.append((row, parameters | {name: value}))


def recent_errors(track: Track) -> tuple[float, float]:
    """RMS of cross-track and turning-angle error [rad] over a track, for a status line."""
    turning = wrap(track.target_course - track.course)
    return float(np.sqrt(np.mean(track.cross_track**2))), float(np.sqrt(np.mean(turning**2)))


def _outer_gain(columns: Columns, parameters: dict[str, float]) -> Any:
    """L, which follows airspeed over line length where GAIN_TAU is set."""
    if not parameters["GAIN_TAU"]:
        return parameters["OUTER_L"]
    delay_s = parameters["GAIN_TAU"] + 0.5 / parameters["LOOP_HZ"]
    turning = np.maximum(columns["airspeed_m_s"] / columns["distance_m"], 1e-6)
    return np.minimum(_GREATEST_GAIN, parameters["GAIN_L_TAU"] / (turning * delay_s))
