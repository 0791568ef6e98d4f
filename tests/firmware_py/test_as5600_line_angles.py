"""Two encoders on simulated buses: angles with their zeros and directions, and what is refused and counted."""

import math

import pytest
from simulated_hardware import MAGNET, STRONG, WEAK, SimulatedEncoder, SimulatedI2C, encoder_bus

from firmware_py.drivers.as5600 import As5600
from firmware_py.drivers.line_angles import JUMP, NO_ANSWER, NO_MAGNET, OUT_OF_RANGE, Axis, LineAngles

STEP = 2 * math.pi / 4096
WRAP_US = 1 << 30


class Line:
    """The line's two encoders; azimuth has its zero at 100, elevation at 4000 and counts backwards."""

    def __init__(self, now: int = 0):
        self.azimuth, self.azimuth_bus = encoder_bus()
        self.elevation, self.elevation_bus = encoder_bus()
        self.angles = LineAngles(Axis(As5600(self.azimuth_bus), 100, 1), Axis(As5600(self.elevation_bus), 4000, -1))
        self.now = now
        self.point(0, 400)

    def point(self, azimuth: int, elevation: int) -> None:
        self.azimuth.raw, self.elevation.raw = (100 + azimuth) % 4096, (4000 - elevation) % 4096

    def sample(self, after_us: int = 20_000):
        self.now = (self.now + after_us) % WRAP_US
        return self.angles.sample(self.now)


def test_the_driver_reads_status_and_angle_in_one_transfer():
    encoder, bus = encoder_bus(0xABC)
    driver = As5600(bus)
    assert driver.read() and (driver.raw, bus.transfers) == (0xABC, 1)
    assert driver.has_magnet() and driver.magnet_advice() == ""
    for status, advice in ((MAGNET | WEAK, "weak"), (MAGNET | STRONG, "strong"), (0, "no magnet"), (WEAK, "no magnet")):
        encoder.status = status
        assert driver.read() and advice in driver.magnet_advice()
        assert driver.has_magnet() == bool(status & MAGNET)
    bus.broken = True
    assert not driver.read()
    assert not As5600(SimulatedI2C(x37=SimulatedEncoder())).read()  # nobody at 0x36


@pytest.mark.parametrize("zero", [0, 1, 100, 2047, 2048, 4095])
@pytest.mark.parametrize("direction", [1, -1])
def test_an_axis_counts_from_its_zero_both_ways_round(zero, direction):
    encoder, bus = encoder_bus()
    axis = Axis(As5600(bus), zero, direction)
    for steps in (-2048, -2047, -1, 0, 1, 1024, 2047):
        encoder.raw = (zero + direction * steps) % 4096
        assert axis.read() == steps


def test_a_sample_holds_azimuth_and_elevation_and_nothing_else():
    line = Line(now=5)
    line.point(-300, 500)
    sample = line.sample()
    assert sample == (20_005, pytest.approx(-300 * STEP), pytest.approx(500 * STEP), 0, 0, 0, 0, 0, 0, 3)
    assert line.angles.refused == [0, 0, 0, 0]


def test_elevation_from_just_below_the_horizon_to_the_zenith():
    for elevation, good in ((-115, False), (-114, True), (0, True), (1024, True), (1025, False), (2000, False)):
        line = Line()
        line.point(0, elevation)
        assert (line.sample() is not None) is good, elevation
        assert line.angles.refused[OUT_OF_RANGE] == (not good)


def test_a_jump_is_judged_by_the_time_that_it_had():
    """Four steps at once, and one more each 300 us; either way, on either axis, and round the back."""
    for after_us, most in ((300, 5), (20_000, 70), (200_000, 670)):
        for jump, good in ((most, True), (most + 1, False)):
            for azimuth, elevation in ((jump, 0), (-jump, 0), (0, jump), (0, -jump)):
                line = Line()
                line.point(2047, 300)
                assert line.sample()
                line.point(2047 + azimuth, 300 + elevation)
                expected = good and -114 <= 300 + elevation <= 1024
                assert (line.sample(after_us) is not None) is expected, (after_us, azimuth, elevation)
                assert line.angles.refused[JUMP] + line.angles.refused[OUT_OF_RANGE] == (not expected)


def test_after_half_a_second_the_line_is_believed_wherever_it_is():
    line = Line(now=WRAP_US - 100_000)
    assert line.sample()
    line.point(1500, 100)
    refused = 0
    while line.sample() is None:
        refused += 1
    assert refused == line.angles.refused[JUMP] == 22  # (1500 - 4) * 300 us later it could have gone there
    line.point(-500, 900)
    assert line.sample(500_001) is not None  # too long ago to say anything about it


def test_a_bus_that_fails_and_a_magnet_that_is_gone_are_counted_and_pass():
    line = Line()
    assert line.sample()
    line.azimuth_bus.broken = True
    assert [line.sample() for _ in range(3)] == [None] * 3
    assert line.angles.refused[NO_ANSWER] == 3
    line.elevation.status = WEAK
    assert line.sample() is None
    assert (line.angles.refused[NO_ANSWER], line.angles.refused[NO_MAGNET]) == (4, 1)
    line.azimuth_bus.broken = False
    line.elevation.status = MAGNET
    assert line.sample() is not None


def test_a_spike_on_the_bus_is_left_out_and_the_flight_goes_on():
    line = Line()
    samples = []
    for tick in range(100):
        line.point(2 * tick, 400 + (tick % 7))
        if tick == 50:
            line.azimuth.raw ^= 0x800
        samples.append(line.sample())
    assert [tick for tick, sample in enumerate(samples) if sample is None] == [50]
    assert line.angles.refused == [0, 0, 0, 1]
