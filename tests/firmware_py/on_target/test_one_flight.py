"""A short flight of the whole autopilot over its codec: found its way, armed, and steers towards the curve."""

import struct
from math import cos, pi, sin

from firmware_py import generated_enums as enums
from firmware_py.autopilot import Autopilot
from firmware_py.loop import step_lockstep
from firmware_py.mavlink import generated_messages as wire
from firmware_py.mavlink.decoder import Decoder
from firmware_py.mavlink.encoder import Encoder
from firmware_py.mavlink.link import MavlinkLink

_VALID = enums.KITE_VALID_AZIMUTH | enums.KITE_VALID_ELEVATION | enums.KITE_VALID_DISTANCE | enums.KITE_VALID_COURSE


class Pair:
    """The firmware's transport, and the other end of it."""

    datagrams = True

    def __init__(self):
        self._waiting = bytearray()
        self._encoder = Encoder(255, 255)
        self._decoder = Decoder()
        self._buffer = bytearray(300)
        self.heard = []

    def read(self):
        data = bytes(self._waiting)
        self._waiting = bytearray()
        return data or None

    def write(self, data):
        self._decoder.feed(data)
        while self._decoder.next_frame(True):
            self.heard.append((self._decoder.message, self._decoder.values))

    def send(self, message, values):
        end = self._encoder.encode(self._buffer, 0, message, values)
        self._waiting += self._buffer[:end]

    def of(self, message):
        return [values for kind, values in self.heard if kind == message]


def fly(pair, autopilot, ticks, first, course, requests=()):
    """Ticks with the kite going round a small circle at 4 m/s; `course` [rad] is what its sensor says."""
    for number in range(first, first + ticks):
        now = number * 20000
        angle = number * 0.04
        sample = (now, 0.02 * sin(angle), 0.7 + 0.02 * cos(angle), 100.0, course, 0.0, 20.0, 0.0, 0.0, _VALID)
        pair.send(wire.KITE_SENSORS, sample)
        for message, values in requests if number == first else ():
            pair.send(message, values)
        pair.send(wire.KITE_TICK, (number, now))
        step_lockstep(autopilot, autopilot.inbox)


def command(number, first, second):
    return wire.COMMAND_LONG, (first, second, 0.0, 0.0, 0.0, 0.0, 0.0, number, 0, 0, 0)


def test_it_arms_tracks_and_steers_to_the_side_of_its_target():
    pair = Pair()
    autopilot = Autopilot(MavlinkLink(pair), True)
    fly(pair, autopilot, 20, 0, 0.0)
    fly(pair, autopilot, 20, 20, 0.0, [
        command(enums.MAV_CMD_COMPONENT_ARM_DISARM, 1.0, 0.0), command(enums.MAV_CMD_DO_SET_MODE, 1.0, 3.0)])
    results = [(values[0], values[1]) for values in pair.of(wire.COMMAND_ACK)]
    assert results == [(enums.MAV_CMD_COMPONENT_ARM_DISARM, 0), (enums.MAV_CMD_DO_SET_MODE, 0)], results
    assert autopilot.modes.mode == enums.KITE_MODE_TRACK
    target = autopilot.target_course
    for offset in (-1.0, 1.0):
        course = target - offset
        fly(pair, autopilot, 10, 40 if offset < 0 else 50, course)
        steering = pair.of(wire.HIL_ACTUATOR_CONTROLS)[-1][2]
        assert steering * offset > 0.0, (offset, steering)


def test_every_tick_ends_and_sends_one_steering():
    pair = Pair()
    autopilot = Autopilot(MavlinkLink(pair), True)
    fly(pair, autopilot, 50, 0, pi / 3)
    assert [values[0] for values in pair.of(wire.KITE_TICK_END)] == list(range(50))
    assert len(pair.of(wire.HIL_ACTUATOR_CONTROLS)) == 50
    assert len(pair.of(wire.HEARTBEAT)) == 1


def test_garbage_between_the_frames_changes_nothing():
    steering = []
    for noise in (b"", bytes((index * 71) & 0xFF for index in range(600)), b"\xfd\xff\x00\x00\x01\x01\x01\x00\x00\x00"):
        pair = Pair()
        autopilot = Autopilot(MavlinkLink(pair), True)
        for number in range(30):
            now = number * 20000
            pair.send(wire.KITE_SENSORS, (now, 0.1, 0.7, 100.0, 0.4, 0.0, 20.0, 0.0, 0.0, _VALID))
            pair._waiting += noise
            pair.send(wire.KITE_TICK, (number, now))
            step_lockstep(autopilot, autopilot.inbox)
        assert len(pair.of(wire.KITE_TICK_END)) == 30
        steering.append(struct.pack("<d", pair.of(wire.KITE_STATE)[-1][5]))
    assert steering[0] == steering[1] == steering[2]
