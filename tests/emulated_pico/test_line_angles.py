"""A board that measures the line with two AS5600 encoders, one on each I2C bus, and steers a servo by it."""

import math
from itertools import pairwise
from typing import Any

import pytest

from protocol import dialect
from tests.emulated_pico.filesystem import filesystem_of
from tests.emulated_pico.flight import START_S
from tests.emulated_pico.pico import EmulatedPico
from tests.emulated_pico.station import ARM, Station
from tests.firmware_py.simulated_hardware import MAGNET, WEAK

AZIMUTH = {"i2c": 0, "sda": 4, "scl": 5, "zero": 1234, "direction": -1}
ELEVATION = {"i2c": 1, "sda": 6, "scl": 7, "zero": 4000, "direction": 1}
SERVO_PIN, NEUTRAL_US = 15, 1500.0
STEP = 2.0 * math.pi / 4096  # of an encoder [rad]
TICK_S = 0.02
STALE, FRESH = "samples stale: steering neutral", "samples fresh again: PARK"


class Line:
    """A line that turns the encoders of `pico`, at `azimuth` and `elevation` in their steps; its `station` watches."""

    def __init__(self, pico: EmulatedPico, azimuth: int, elevation: int):
        self.azimuth, self.elevation = azimuth, elevation
        self.station = Station(pico)
        self._pico = pico
        self.turn(0, 0)
        for bus in (0, 1):
            pico.encoder(bus, status=MAGNET, answers=True)

    def turn(self, azimuth: int, elevation: int) -> None:
        """Turn by so many steps, at once."""
        self.azimuth += azimuth
        self.elevation += elevation
        self._pico.encoder(0, raw=(AZIMUTH["zero"] - self.azimuth) % 4096)
        self._pico.encoder(1, raw=(ELEVATION["zero"] + self.elevation) % 4096)

    def fly(self, seconds: float) -> list[bool]:
        """Turn every two ticks, as by a kite that flies sideways and down; say for each turn if it was seen by then."""
        seen = []
        for _ in range(round(seconds / TICK_S / 2)):
            self.turn(6, -2)
            self.station.run(2 * TICK_S)
            seen.append(self.is_seen())
        return seen

    def is_seen(self) -> bool:
        """True if the board's last word is that the line is where it is."""
        state = self.state()
        return (state.azimuth, state.elevation) == pytest.approx(
            (self.azimuth * STEP, self.elevation * STEP), abs=1e-6)

    def state(self) -> Any:
        """The last KITE_STATE."""
        return self.station.of_kind("KITE_STATE")[-1]


@pytest.fixture
def pico(board_folder, switch_on) -> EmulatedPico:
    """A Pico with line angles and servo, switched on; without its resistors a bus would seem to be held low."""
    pico = switch_on(filesystem_of(board_folder(
        SENSORS="line-angles", AZIMUTH=AZIMUTH, ELEVATION=ELEVATION, SERVO_PIN=SERVO_PIN)))
    for encoder in (AZIMUTH, ELEVATION):
        pico.pin(encoder["sda"], True)
        pico.pin(encoder["scl"], True)
    return pico


def assert_no_tick_lost(pico: EmulatedPico, since: float) -> None:
    """All ticks since `since` [s], when this was asked last, have fed the watchdog at the loop's rate."""
    feeds = pico.measured().feeds
    assert len(feeds) == pytest.approx((pico.now - since) / TICK_S, abs=1)
    assert max(after - before for before, after in pairwise(feeds)) < 2 * TICK_S


def test_it_steers_by_its_encoders_and_lets_go_without_them(pico):
    line = Line(pico, azimuth=100, elevation=496)
    station = line.station
    pico.run_until_printed("running as system", START_S)
    station.hear("KITE_STATE")
    assert line.is_seen()
    assert pico.pulse_us(SERVO_PIN) == pytest.approx(NEUTRAL_US, abs=1.0)

    station.command(ARM, 1.0)
    pico.measured()
    began = pico.now
    assert all(line.fly(2.0))
    assert pico.pulse_us(SERVO_PIN) > NEUTRAL_US + 100.0  # up again
    assert_no_tick_lost(pico, began)

    for bus, fault, cure in ((1, {"status": WEAK}, {"status": MAGNET}), (0, {"answers": False}, {"answers": True})):
        station.forget()
        began = pico.now
        pico.encoder(bus, **fault)
        assert not any(line.fly(0.8))
        state = line.state()
        assert state.status & dialect.KITE_STATUS_STALE and state.mode == dialect.KITE_MODE_PARK
        assert station.texts() == [STALE]
        assert pico.pulse_us(SERVO_PIN) == pytest.approx(NEUTRAL_US, abs=1.0)

        pico.encoder(bus, **cure)
        assert all(line.fly(0.8))
        assert not line.state().status & dialect.KITE_STATUS_STALE
        assert station.texts() == [STALE, FRESH]
        assert pico.pulse_us(SERVO_PIN) > NEUTRAL_US + 100.0
        assert_no_tick_lost(pico, began)
    assert line.state().overruns == 0
