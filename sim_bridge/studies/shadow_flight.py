"""A real flight with the firmware as its shadow: it receives the recorded samples over MAVLink, and moves nothing.

The firmware sees only positions and finds its own turning angle, which is compared with the recorded course. Its
steering, for an eight fitted to the flight, has no effect.
"""

from collections.abc import Callable
from math import ceil, isfinite, nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from kite_analysis.angles import wrap
from kite_analysis.figure_eight import Array, TargetEight
from kite_analysis.figures import legend_above, new_figure
from kite_analysis.flights.real_flight import fit_eight, read_flight
from kite_analysis.flights.record import FlightRecord
from kite_analysis.plots import draw_turning_angle
from protocol import dialect
from sim_bridge.equipment.sensors import Sample, make_sample
from sim_bridge.flight.preflight import Preflight
from sim_bridge.runs.run import make_runtime
from sim_bridge.runtimes.tick_output import clock_us
from sim_bridge.scenario.scenario import Scenario, load_scenario

# In wire order: what of a row goes into a sample, and its bit; course and heading are left to the firmware.
_SENT = (
    ("azimuth", dialect.KITE_VALID_AZIMUTH), ("elevation", dialect.KITE_VALID_ELEVATION),
    ("distance", dialect.KITE_VALID_DISTANCE), ("", 0), ("", 0), ("airspeed", dialect.KITE_VALID_AIRSPEED),
    ("tether_force", dialect.KITE_VALID_TETHER_FORCE), ("steering", dialect.KITE_VALID_STEERING),
)
_FROM_POSITIONS = 2.0


class ShadowFlight(NamedTuple):
    """A flight and the firmware's response, a row per sample."""

    data: FlightRecord
    eight: TargetEight
    course: Array  # the firmware's turning angle [rad]
    steering_asked: Array
    tracking: Array  # True where the firmware was in TRACK
    numbers: dict[str, Any]


def shadow_scenario(data: FlightRecord) -> Scenario:
    """The v3-flight-paper scenario with the eight of this flight, its direction, and positions as the only source.

    Without prediction, as the commanded steering has no effect here.
    """
    used = data.selected & np.isfinite(data.azimuth) & np.isfinite(data.elevation)
    eight = fit_eight(data.azimuth[used], data.elevation[used])
    scenario = load_scenario("v3-flight-paper")
    where = "the eight fitted to this flight"
    for name, value in (
        ("EIGHT_AZIMUTH", np.degrees(eight.azimuth)), ("EIGHT_ELEVATION", np.degrees(eight.elevation)),
        ("EIGHT_HALF_W", np.degrees(eight.half_width)), ("EIGHT_HALF_H", np.degrees(eight.half_height)),
        ("EIGHT_DIRECTION", eight.direction), ("COURSE_SOURCE", _FROM_POSITIONS),
    ):
        scenario.set_parameter(name, float(value), where)
    return scenario


def fly_shadow(path: Path, runtime_name: str, notice: Callable[[str], None],
               columns: Path | None = None, interpreter: str | None = None) -> ShadowFlight:
    """Fly the firmware as the shadow of the flight in `path`.

    `columns` describes the file's columns (default: those of the public flight), `interpreter`: see RunOptions.

    Raises:
        FlightDataError: the file is not a flight.
        ScenarioError, FirmwareError: it cannot be flown.
    """
    data = read_flight(path, columns)
    scenario = shadow_scenario(data)
    runtime = make_runtime(runtime_name, False, False, notice, interpreter)
    period_s = 1.0 / scenario.parameter("LOOP_HZ")
    preflight = Preflight(scenario)
    said: list[tuple[float, float, float]] = []
    last = (np.nan, np.nan, 0.0)
    try:
        runtime.start()
        row = 0
        for tick in range(ceil(data.time_s[-1] / period_s) + 2):
            time_s = tick * period_s
            samples: list[Sample] = []
            while row < len(data.time_s) and data.time_s[row] <= time_s + 1e-9:
                samples.append(_sample(data, row))
                row += 1
            output = runtime.exchange(tick, time_s, samples, preflight.requests(tick), [])
            preflight.hear(output.replies)
            if output.state:
                last = (output.state.course, output.state.steering_asked, output.state.mode)
            said += [last] * (row - len(said))
    finally:
        runtime.stop()
    course, steering, mode = np.array(said).T
    numbers = _compare(data, course)
    numbers |= {"file": path.name, "runtime": runtime.name, "samples": len(course)}
    eight = TargetEight.from_parameters(scenario.parameter)
    return ShadowFlight(data, eight, course, steering, mode == dialect.KITE_MODE_TRACK, numbers)


def _sample(data: FlightRecord, row: int) -> Sample:
    values = [float(getattr(data, quantity)[row]) if quantity else nan for quantity, _ in _SENT]
    valid = sum(bit for value, (_, bit) in zip(values, _SENT, strict=True) if isfinite(value))
    azimuth, elevation, distance, course, heading, airspeed, force, steering = (
        value if isfinite(value) else 0.0 for value in values)
    return make_sample(
        clock_us(float(data.time_s[row])), azimuth, elevation, distance, course, heading, airspeed, force,
            steering, valid)


def _compare(data: FlightRecord, course: Array) -> dict[str, Any]:
    used = data.selected & np.isfinite(course) & np.isfinite(data.course)
    error = np.degrees(wrap(course - data.course)[used])
    return {
        "turning_angle_rms_deg": float(np.sqrt(np.mean(error**2))),
        "turning_angle_bias_deg": float(np.mean(error)),
        "reel_out_s": float(np.sum(data.selected) * np.median(np.diff(data.time_s))),
    }


def plot_shadow(flight: ShadowFlight, title: str) -> Any:
    """The firmware's turning angle with the recorded course, and its steering with the recorded one."""
    figure, (top, bottom) = new_figure(9.0, 6.5, rows=2)
    used = flight.data.selected
    time_s = flight.data.time_s[used]
    draw_turning_angle(top, time_s, flight.course[used], flight.data.course[used],
                       ("firmware, from positions", "recorded course"))
    asked = np.where(flight.tracking, flight.steering_asked, np.nan)[used]
    bottom.plot(time_s, flight.data.set_steering[used], "--", color="#d1495b", lw=1.0, label="recorded, as commanded")
    bottom.plot(time_s, asked, color="#1f4e9c", lw=1.0, label="firmware, for the eight fitted to the flight")
    bottom.set(xlabel="time [s]", ylabel="steering")
    bottom.grid(alpha=0.3)
    legend_above(bottom)
    top.set_xlabel("")
    figure.suptitle(f"{title}: recorded, and the firmware as its shadow")
    figure.supxlabel(flight.data.attribution, x=0.995, ha="right", fontsize=6, color="#666666")
    return figure
