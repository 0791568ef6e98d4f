"""The closed loop: plant, sensors, links, firmware, actuator; tick by tick."""

from collections.abc import Callable
from math import ceil, inf, nan, radians, sin
from typing import Any

from kite_analysis.figure_eight import TargetEight
from kite_analysis.metrics import Metrics, Track, measure, not_measured
from sim_bridge.equipment.actuator import Actuator
from sim_bridge.equipment.sensors import SAMPLE_BYTES, Sample, Sensors
from sim_bridge.flight.judgement import Judge, recent_errors
from sim_bridge.flight.plant_choice import make_plant
from sim_bridge.flight.preflight import PREFLIGHT_TICKS, Preflight
from sim_bridge.flight.start_state import lead_in, start_position
from sim_bridge.flight.tick_record import TickRecord
from sim_bridge.flight.truth_columns import TruthRow
from sim_bridge.flight.truth_table import TruthTable
from sim_bridge.links.emulation import LinkDirection
from sim_bridge.links.ground_path import GroundPath
from sim_bridge.links.link_settings import patience_s, without
from sim_bridge.links.wire import STEERING_BYTES
from sim_bridge.plants.truth import Truth
from sim_bridge.runtimes.interface import Runtime
from sim_bridge.runtimes.tick_output import ToldState, clock_us
from sim_bridge.scenario.scenario import Scenario
from sim_bridge.wind.wind import Wind


class Flight:
    """One flight of `scenario` with the firmware in `runtime`.

    `ground` gives the datagrams that reach the firmware in a tick and takes what it sends; `watch` is called with a
    TickRecord after each tick. Time starts below 0 with the preflight; `truth` holds the truth from t = 0 on.
    """

    def __init__(self, scenario: Scenario, runtime: Runtime, ground: GroundPath | None = None,
                 stations: Any = None, watch: Callable[[TickRecord], None] | None = None):
        self.scenario = scenario
        self.runtime = runtime
        self.period_s = 1.0 / scenario.parameter("LOOP_HZ")
        self.eight = TargetEight.from_parameters(scenario.parameter)
        self.plant = make_plant(scenario, *start_position(scenario.start, self.eight))
        self.actuator = Actuator(scenario.actuator)
        self.truth = TruthTable()
        self.overruns = 0
        self._ground = ground
        self._stations = stations
        self._watch = watch
        seed = scenario.run.seed
        self._sensors = Sensors(scenario.sensors, seed, scenario.errors)
        eight_m = scenario.plant.line_length_m * sin(radians(scenario.parameter("EIGHT_ELEVATION")))
        self._wind = Wind(scenario.wind, self.period_s, seed, eight_m)
        self._start = self.plant.truth()
        self._longest_step_s = self.plant.step_s * (2.0 if self.actuator.ideal else 1.0)
        self._control = down, up = scenario.link.control
        self._down = LinkDirection(down, f"{seed}:control.down")
        self._up = LinkDirection(up, f"{seed}:control.up")
        self._newest_steering_s = -inf
        self._preflight = Preflight(scenario)
        lead_in_s = max(runtime.lead_in_s, PREFLIGHT_TICKS * self.period_s)
        self.tick = -ceil((lead_in_s + patience_s(down, SAMPLE_BYTES, self.period_s)) / self.period_s)
        self._first_tick = self.tick
        self._state: ToldState | None = None
        self._judge = Judge(scenario)

    @property
    def time_s(self) -> float:
        """Time of the next tick, 0 at the start of the flight proper."""
        return self.tick * self.period_s

    def step(self) -> None:
        """Run one tick and fly the plant on to the next.

        Raises:
            FirmwareError: the firmware was not ready in time, or failed.
        """
        tick = self.tick
        time_s = tick * self.period_s
        if tick == 0:
            self._preflight.check()
        flying = tick >= 0
        truth = self.plant.truth() if flying else lead_in(self._start, time_s)
        self.actuator.apply_due(time_s + 1e-9)
        self._sensors.follow(time_s, truth, self.actuator.motor)
        if self._sensors.is_due(time_s):
            sample = self._sensors.sample(clock_us(time_s), truth, self.actuator.motor)
            self._down.send(time_s, sample, SAMPLE_BYTES)
        samples: list[Sample] = []
        for parcel in self._down.due(time_s):
            samples.append(parcel.item)
        datagrams = self._hear_stations(time_s) if self._ground else []
        requests = self._preflight.requests(tick) if not self._preflight.done else []
        output = self.runtime.exchange(tick - self._first_tick, time_s, samples, requests, datagrams)
        if not self._preflight.done:
            self._preflight.hear(output.replies)
        for sent_s, steering in output.steering:
            self._up.send(sent_s, (sent_s, steering), STEERING_BYTES)
        heard = self._tell_stations(time_s, output.frames) if self._ground else []
        self._judge.hear(time_s, output, tick if flying else 0)
        if output.state is not None:
            self._state = output.state
            self.overruns = output.state.overruns
        row = self._record(time_s, truth) if flying else None
        if self._watch is not None:
            self._watch(TickRecord(tick, time_s, samples, datagrams, output, heard,
                                   None if row is None else TruthRow._make(row)))
        self.tick = tick + 1
        self._advance(time_s, self.tick * self.period_s, flying)

    @property
    def rows(self) -> list[TruthRow]:
        """The truth so far, tick by tick from t = 0 on."""
        return self.truth.rows()

    @property
    def trouble(self) -> str | None:
        """Reason of a crash; None while the kite flies."""
        return self.plant.trouble

    def fly(self, until_s: float) -> None:
        """Step until `until_s`, or until the kite crashes."""
        until_s -= 1e-9
        while self.tick * self.period_s < until_s and not self.plant.trouble:
            self.step()

    @property
    def delay_asked_s(self) -> float:
        """Delay of the control path there and back that the scenario asks for [s]."""
        return self._control.delay_s

    @property
    def delay_emulated_s(self) -> float:
        """What of it is emulated at present [s]."""
        return self._down.settings.delay_s + self._up.settings.delay_s

    def allow_for(self, delay_s: float) -> None:
        """A real board takes `delay_s` [s] itself: emulate only the rest of the control path's delay."""
        down, up = without(self._control, delay_s, self.period_s)
        self._down.use(down)
        self._up.use(up)

    def track(self) -> Track:
        """The flight so far, as arrays."""
        return self._judge.track(self.truth.columns())

    def metrics(self) -> Metrics:
        """The flight's numbers and the verdict, after the scenario's settling time."""
        if not len(self.truth):
            return not_measured("interrupted before the flight began")
        return measure(self.track(), self.scenario.run.settle_s, self.trouble)

    def recent_errors(self, seconds: float) -> tuple[float, float]:
        """RMS of cross-track and turning-angle error [rad] over the last `seconds`, for a status line."""
        first = max(0, len(self.truth) - max(1, round(seconds / self.period_s)))
        return recent_errors(self._judge.track(self.truth.columns(first), first))

    def _hear_stations(self, time_s: float) -> list[bytes]:
        assert self._ground is not None
        if self._stations:
            for datagram in self._stations.receive():
                self._ground.from_station(time_s, datagram)
        return self._ground.to_firmware(time_s)

    def _tell_stations(self, time_s: float, frames: list[bytes]) -> list[bytes]:
        assert self._ground is not None
        self._ground.from_firmware(time_s, frames)
        heard = self._ground.to_stations(time_s)
        if self._stations:
            self._stations.send(heard)
        return heard

    def _record(self, time_s: float, truth: Truth) -> list[float]:
        """Add the truth at a tick; see TruthRow."""
        state = self._state
        course = target_course = cross_track = path_parameter = status = nan
        if state is not None:
            course, target_course, cross_track = state.course, state.target_course, state.cross_track
            path_parameter, status = state.path_parameter, float(state.status)
        air = self._wind.air
        row = [
            time_s, truth.azimuth, truth.elevation, truth.course, truth.heading, truth.airspeed, self.actuator.position,
            course, target_course, cross_track, path_parameter, self._judge.steering_asked, status,
            float(self._judge.mode(time_s)), truth.distance, truth.tether_force, air.speed_m_s * air.gust,
            air.direction_rad]
        self.truth.add(row)
        return row

    def _advance(self, start_s: float, end_s: float, flying: bool) -> None:
        """Fly from one tick to the next, with each steering command felt at its exact time."""
        actuator = self.actuator
        for parcel in self._up.due(end_s):
            sent_s, steering = parcel.item
            if sent_s >= self._newest_steering_s:  # one that was overtaken on the way is of no use
                self._newest_steering_s = sent_s
                actuator.command(parcel.time_s if parcel.time_s > start_s else start_s, steering)
        now = start_s
        plant, air = self.plant, self._wind.air
        while now < end_s - 1e-9:
            actuator.apply_due(now + 1e-9)
            change = actuator.next_change()
            until = change if change < end_s else end_s
            duration = until - now
            steps = ceil(duration / self._longest_step_s - 1e-6) or 1
            dt = duration / steps
            for _ in range(steps):  # while no new command is felt
                steering = actuator.advance(dt)
                if flying:
                    plant.step(dt, steering, air)
            now = until
        if flying:
            self._wind.advance()
