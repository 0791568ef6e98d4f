"""The real firmware for ground stations in simulated time."""

from collections.abc import Callable

import pytest

from firmware_py.generated_parameters import PARAMETERS
from protocol import dialect
from sim_bridge.ground_path import GroundLink
from sim_bridge.link_emulation import LinkSettings
from sim_bridge.runtimes.memory import MemoryRuntime

_PERIOD_S = 0.02
_VALID = (dialect.KITE_VALID_AZIMUTH | dialect.KITE_VALID_ELEVATION | dialect.KITE_VALID_DISTANCE
          | dialect.KITE_VALID_COURSE | dialect.KITE_VALID_AIRSPEED)


class SimulatedKite:
    """A kite at rest in the sky, its firmware, and an emulated radio link; time passes while somebody receives."""

    def __init__(self, loss: float, round_trip_s: float, seed: int):
        settings = LinkSettings(delay_s=round_trip_s / 2, loss=loss)
        self._link = GroundLink((settings, settings), seed)
        self._runtime = MemoryRuntime()
        self._tick = 0
        self._arrived: list[bytes] = []
        self.transport = self

    def clock(self) -> float:
        """Simulated seconds."""
        return self._tick * _PERIOD_S

    def firmware_parameter(self, name: str) -> float:
        """The value that the firmware holds."""
        names = [entry[0] for entry in PARAMETERS]
        return self._runtime.autopilot.parameters.values[names.index(name)]

    def send(self, data: bytes) -> None:
        """What a ground station sends."""
        self._link.from_station(self.clock(), data)

    def receive(self, timeout_s: float) -> bytes:
        """Let time pass until a frame comes down, or `timeout_s` is over."""
        end = self.clock() + timeout_s
        while not self._arrived and self.clock() < end - 1e-9:
            self._step()
        return self._arrived.pop(0) if self._arrived else b""

    def close(self) -> None:
        """Nothing is open."""

    def _step(self) -> None:
        now = self.clock()
        sample = (round(now * 1e6), 0.1, 0.7, 100.0, 0.5, 0.5, 20.0, 0.0, 0.0, _VALID)
        output = self._runtime.exchange(self._tick, now, [sample], [], self._link.to_firmware(now))
        self._link.from_firmware(now, output.frames)
        self._arrived += self._link.to_stations(now)
        self._tick += 1


@pytest.fixture
def simulated_kite() -> Callable[..., SimulatedKite]:
    """Make a kite: `simulated_kite(loss=0.2, round_trip_s=1.0, seed=1)`; loss is for each direction."""

    def make(loss: float = 0.2, round_trip_s: float = 1.0, seed: int = 1) -> SimulatedKite:
        return SimulatedKite(loss, round_trip_s, seed)

    return make
