"""The real firmware for ground stations in simulated time."""

from collections.abc import Callable

import pytest

from ground.link.links import Links
from ground.link.transports import LinkError, OnePeer
from ground.session import Session
from protocol import dialect
from protocol.parameter_table import load_parameters
from sim_bridge.flight.flight import Flight
from sim_bridge.links.ground_path import GroundLink
from sim_bridge.links.link_settings import LinkSettings, PathSettings
from sim_bridge.runtimes.memory import MemoryRuntime
from sim_bridge.runtimes.tick_output import TickOutput, clock_us
from sim_bridge.scenario.scenario import Scenario, load_scenario
from tests.ground.operator_at_work import Operator

_PERIOD_S = 0.02
_VALID = (dialect.KITE_VALID_AZIMUTH | dialect.KITE_VALID_ELEVATION | dialect.KITE_VALID_DISTANCE
          | dialect.KITE_VALID_COURSE | dialect.KITE_VALID_AIRSPEED)
_START_S = 1_700_000_000.0  # the wall clock when the simulation begins


class SimulatedLink(OnePeer):
    """One emulated radio link to a simulated kite, as a ground station's transport. `broken`: the port is gone."""

    def __init__(self, kite: "SimulatedKite", settings: LinkSettings, seed: int) -> None:
        self.emulated = GroundLink(PathSettings(settings, settings), seed)
        self.arrived: list[bytes] = []
        self.sent = 0
        self.broken = False
        self._kite = kite

    def open(self) -> "SimulatedLink":
        """As a link's opener does."""
        if self.broken:
            raise LinkError("link simulated: serial port disconnected")
        self.arrived.clear()
        return self

    def send(self, data: bytes) -> None:
        """What a ground station sends."""
        self.open_or_raise()
        self.sent += 1
        self.emulated.from_station(self._kite.clock(), data)

    def receive(self, timeout_s: float) -> bytes:
        """Let time pass until a frame comes down, or `timeout_s` is over."""
        self.open_or_raise()
        end = self._kite.clock() + timeout_s
        while not self.arrived and self._kite.clock() < end:
            self._kite.step()
        return self.arrived.pop(0) if self.arrived else b""

    def open_or_raise(self) -> None:
        """Raise LinkError where serial port disconnected."""
        if self.broken:
            raise LinkError("link simulated: serial port disconnected")

    def fileno(self) -> None:
        """Nothing that an operating system could wait for."""

    def close(self) -> None:
        """Nothing is open."""


class SimulatedKite:
    """A kite at rest in the sky, its firmware, and emulated radio links; time passes while somebody receives.

    `speed`: how much faster its time passes than that of the ground station and the links.
    """

    def __init__(self, links: list[LinkSettings], seed: int):
        self.radios = [SimulatedLink(self, settings, seed + index) for index, settings in enumerate(links)]
        self.speed = 1.0
        self._tick = 0
        self._now_s = 0.0
        self.start()

    def start(self) -> None:
        """Switch the board on, with parameters at their defaults."""
        self._runtime = MemoryRuntime()
        self._started = self._tick

    def clock(self) -> float:
        """Simulated seconds of the ground station."""
        return self._now_s

    def wall_clock(self) -> float:
        """Seconds since 1970."""
        return _START_S + self.clock()

    def change_link(self, down: LinkSettings, up: LinkSettings) -> None:
        """From now on the first radio is another: `down` to the ground, `up` to the kite."""
        self.radios[0].emulated = GroundLink(PathSettings(up, down), 1)

    def sleep(self, seconds: float) -> None:
        """Let time pass."""
        end = self.clock() + seconds
        while self.clock() < end:
            self.step()

    def links(self) -> Links:
        """A ground station's links to it, open."""
        names = [f"simulated {index}" if index else "simulated" for index in range(len(self.radios))]
        links = Links({name: radio.open for name, radio in zip(names, self.radios, strict=True)},
                      self.clock, print, self.sleep)
        links.open()
        return links

    def session(self, on_notice: Callable[[str], None], timeout_s: float = 30.0) -> Session:
        """A session that has found the vehicle."""
        session = Session(self.links(), on_notice)
        session.find_vehicle(timeout_s)
        return session

    def firmware_parameter(self, name: str) -> float:
        """The value that the firmware holds."""
        names = list(load_parameters())
        return self._runtime.autopilot.parameters.values[names.index(name)]

    def step(self) -> None:
        """One tick of the firmware, with what its links let through."""
        now, flown = self.clock(), self._tick * _PERIOD_S
        sample = (clock_us(flown), 0.1, 0.7, 100.0, 0.5, 0.5, 20.0, 0.0, 0.0, _VALID)
        arrived = [datagram for radio in self.radios for datagram in radio.emulated.to_firmware(now)]
        output = self._runtime.exchange(self._tick - self._started, flown, [sample], [], arrived)
        for radio in self.radios:
            radio.emulated.from_firmware(now, output.frames)
            radio.arrived += radio.emulated.to_stations(now)
        self._tick += 1
        self._now_s += _PERIOD_S / self.speed


@pytest.fixture
def simulated_kite() -> Callable[..., SimulatedKite]:
    """Make a kite: `simulated_kite(loss=0.2, round_trip_s=1.0, seed=1)`; loss is for each direction.

    `links=[LinkSettings(...), ...]` instead gives it several, each with the same settings both ways.
    """

    def make(loss: float = 0.2, round_trip_s: float = 1.0, seed: int = 1,
             links: list[LinkSettings] | None = None) -> SimulatedKite:
        return SimulatedKite(links or [LinkSettings(delay_s=round_trip_s / 2, loss=loss)], seed)

    return make


class _Suspended(MemoryRuntime):
    """A firmware that does nothing."""

    def exchange(self, *inputs, **named) -> TickOutput:
        """Nothing comes of anything."""
        return TickOutput()


class FlyingKite(SimulatedKite):
    """A kite that flies a scenario, its firmware in the loop, with one emulated radio link."""

    def __init__(self, scenario: Scenario, link: LinkSettings, seed: int):
        self._scenario = scenario
        super().__init__([link], seed)

    def start(self) -> None:
        """Begin the flight, and be in TRACK."""
        self._runtime = MemoryRuntime()
        radio = self.radios[0]
        self.flight = Flight(self._scenario, self._runtime, radio.emulated,
                             watch=lambda record: radio.arrived.extend(record.heard))
        self.flight.fly(2.0)

    def clock(self) -> float:
        """Seconds of the flight."""
        return self.flight.time_s

    def step(self) -> None:
        """One tick."""
        self.flight.step()

    def change_link(self, down: LinkSettings, up: LinkSettings) -> None:
        """See SimulatedKite."""
        super().change_link(down, up)
        self.flight._ground = self.radios[0].emulated

    def suspend_firmware(self, seconds: float) -> None:
        """Fly on for so long with a firmware that does nothing: what it would have heard waits for it."""
        runtime, self.flight.runtime = self.flight.runtime, _Suspended()
        self.sleep(seconds)
        self.flight.runtime = runtime

    def freeze_sensors(self, what: str) -> None:
        """From now on the samples' "values", or their "stamps", stay as they are."""
        take, last = self.flight._sensors.sample, []

        def frozen(time_us, truth, steering):
            sample = take(time_us, truth, steering)
            last.append(sample)
            return (sample[0], *last[0][1:]) if what == "values" else (last[0][0], *sample[1:])

        self.flight._sensors.sample = frozen


@pytest.fixture
def flying_kite() -> Callable[..., FlyingKite]:
    """Make a kite that flies: `flying_kite("paper-delay", "link.control.delay_s=0.1", INNER_P=2.0, loss=0.1)`."""

    def make(scenario: str, *settings: str, loss: float = 0.0, round_trip_s: float = 0.1, seed: int = 1,
             **parameters: float) -> FlyingKite:
        flown = load_scenario(scenario)
        for text in settings:
            flown.set_text(text, "--set")
        for name, value in parameters.items():
            flown.set_parameter(name, value, "here")
        return FlyingKite(flown, LinkSettings(delay_s=round_trip_s / 2, loss=loss), seed)

    return make


@pytest.fixture
def operator_of(capsys, tmp_path, monkeypatch) -> Callable[[SimulatedKite], Operator]:
    """An operator at the keyboard for a kite of yours, with a state folder of his own."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return lambda kite: Operator(kite, capsys)


@pytest.fixture
def operator(simulated_kite, operator_of) -> Operator:
    """An operator with a kite on a good link."""
    return operator_of(simulated_kite(loss=0.0, round_trip_s=0.1))
