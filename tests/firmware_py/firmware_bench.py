"""The firmware with its real codec on a bench: a ground station of pymavlink's making, and a kite in the sky."""

import math
from collections.abc import Callable
from typing import Any

from protocol import dialect
from protocol.parameter_table import load_parameters
from sim_bridge.equipment.sensors import Sample
from sim_bridge.plants.turning_rate import TurningRatePlant
from sim_bridge.plants.turning_rate_settings import TurningRateSettings
from sim_bridge.runtimes.memory import MemoryRuntime
from sim_bridge.runtimes.tick_output import clock_us
from sim_bridge.wind.air import Air
from sim_bridge.wind.wind_settings import WindSettings

NAMES = list(load_parameters())
STANDBY, MANUAL, PARK, TRACK = (
    dialect.KITE_MODE_STANDBY, dialect.KITE_MODE_MANUAL, dialect.KITE_MODE_PARK, dialect.KITE_MODE_TRACK)
ARM, DO_SET_MODE = dialect.MAV_CMD_COMPONENT_ARM_DISARM, dialect.MAV_CMD_DO_SET_MODE
REQUEST_MESSAGE = dialect.MAV_CMD_REQUEST_MESSAGE
PERIOD_S = 0.02
TICKS_PER_SECOND = 50
POSITION = dialect.KITE_VALID_AZIMUTH | dialect.KITE_VALID_ELEVATION
COURSE = dialect.KITE_VALID_COURSE
HEADING = dialect.KITE_VALID_HEADING
DISTANCE = dialect.KITE_VALID_DISTANCE
AIRSPEED = dialect.KITE_VALID_AIRSPEED
STEERING = dialect.KITE_VALID_STEERING
EVERYTHING = 0xFF

_AIR = Air(8.0)

Sky = Callable[[float, float], Sample | None]


def sample(time_us: int, azimuth: float = 0.1, elevation: float = 0.7, distance: float = 100.0, course: float = 0.5,
           heading: float = 0.5, airspeed: float = 20.0, tether_force: float = 50.0, steering: float = 0.0,
           valid: int = EVERYTHING) -> Sample:
    """Values of KITE_SENSORS: a kite hovering high in the sky, where nothing else is said."""
    return (time_us, azimuth, elevation, distance, course, heading, airspeed, tether_force, steering, valid)


def hovering(**fields: float) -> Sky:
    """A kite that stands still, with the `fields` of its samples as given."""
    return lambda time_s, steering: sample(clock_us(time_s), **fields)  # type: ignore[arg-type]


class FlyingKite:
    """A sky with a kite that obeys the turning-rate law, with the constants that the parameters have by default.

    A sample is taken every `every` ticks.
    """

    def __init__(self, azimuth: float = 0.2, elevation: float = 0.7, course: float = 0.5, every: int = 1):
        up = (-math.sin(elevation) * math.cos(azimuth), -math.sin(elevation) * math.sin(azimuth), math.cos(elevation))
        across = (math.sin(azimuth), -math.cos(azimuth), 0.0)
        nose = tuple(math.cos(course) * e1 + math.sin(course) * e2 for e1, e2 in zip(up, across, strict=True))
        position = (math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth),
                    math.sin(elevation))
        self.plant = TurningRatePlant(TurningRateSettings(), WindSettings(), position, (nose[0], nose[1], nose[2]))
        self._every = every
        self._ticks = 0

    def __call__(self, time_s: float, steering: float) -> Sample | None:
        if self._ticks:
            for _ in range(2):
                self.plant.step(0.5 * PERIOD_S, steering, _AIR)
        self._ticks += 1
        truth = self.plant.truth()
        x, y, z = truth.position
        if (self._ticks - 1) % self._every:
            return None
        return sample(clock_us(time_s), math.atan2(y, x), math.asin(z), truth.distance, truth.course, truth.heading,
                      truth.airspeed, 0.0, steering)


class Bench:
    """The firmware in simulated time, one `step` a tick. `heard` keeps (time [s], message) of all that it says."""

    def __init__(self, sky: Sky | None = None):
        self.sky: Sky | None = sky or hovering()
        self.runtime = MemoryRuntime()
        self.autopilot = self.runtime.autopilot
        self.time_s = 0.0
        self.period_s = PERIOD_S
        self.heard: list[tuple[float, Any]] = []
        self.steering: list[float] = []
        self._tick = 0
        self._station = dialect.MAVLink(None, 255, 190)
        self._parser = dialect.MAVLink(None)
        self._waiting: list[bytes] = []

    def tell(self, *messages: dialect.MAVLink_message) -> None:
        """Send `messages` as a ground station; they arrive with the next tick, in one datagram each."""
        for message in messages:
            self._waiting.append(message.pack(self._station))
            self._station.seq = (self._station.seq + 1) % 256

    def step(self) -> list[Any]:
        """Run a tick; return the messages that it sent, bar the steering."""
        steering = self.steering[-1] if self.steering else 0.0
        taken = self.sky(self.time_s, steering) if self.sky else None
        output = self.runtime.exchange(
            self._tick, self.time_s, [taken] if taken else [], [], self._waiting)
        self._waiting = []
        messages = [self._parser.decode(bytearray(frame)) for frame in output.frames]
        self.heard += [(self.time_s, message) for message in messages]
        self.steering += [steering for _, steering in output.steering]
        self._tick += 1
        self.time_s = round(self.time_s + self.period_s, 6)
        return messages

    def run(self, seconds: float) -> list[Any]:
        """Run for `seconds`; return the messages sent meanwhile."""
        messages = []
        for _ in range(round(seconds / self.period_s)):
            messages += self.step()
        return messages

    def ask(self, *messages: dialect.MAVLink_message) -> list[Any]:
        """Send `messages` and run one tick; return what it sent."""
        self.tell(*messages)
        return self.step()

    def ask_for(self, kind: str, message: dialect.MAVLink_message) -> Any:
        """Send `message` and run until an answer of type `kind` comes, half a second at most; return it."""
        self.tell(message)
        for _ in range(TICKS_PER_SECOND // 2):
            if found := of_kind(kind, self.step()):
                assert len(found) == 1
                return found[0]
        raise AssertionError(f"no {kind} in answer to {message}")

    def set(self, **parameters: float) -> None:
        """Set parameters over the wire, each of which must be accepted."""
        for name, value in parameters.items():
            answer = self.ask_for("PARAM_VALUE", set_parameter(name, value))
            assert (answer.param_id, answer.param_value) == (name, value)

    def value(self, name: str) -> float:
        """The value that the firmware holds."""
        return self.autopilot.parameters.values[NAMES.index(name)]

    def arm(self) -> int:
        """Ask to arm; return the result."""
        return self.command(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)

    def disarm(self) -> int:
        """Ask to disarm; return the result."""
        return self.command(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 0.0)

    def change_mode(self, mode: float) -> int:
        """Ask for a mode; return the result."""
        return self.command(dialect.MAV_CMD_DO_SET_MODE, 1.0, mode)

    def command(self, command: int, first: float = 0.0, second: float = 0.0) -> int:
        """Send a command and run until it is acknowledged; return the result."""
        answer = self.ask_for("COMMAND_ACK", command_long(command, first, second))
        assert answer.command == command
        assert (answer.target_system, answer.target_component) == (255, 190)
        assert (answer.progress, answer.result_param2) == (0, 0)
        return answer.result

    def start(self, mode: int) -> None:
        """Arm and go to `mode`, with what was said about it forgotten, and the steering's history too."""
        self.step()
        assert self.arm() == dialect.MAV_RESULT_ACCEPTED
        if mode != dialect.KITE_MODE_PARK:
            assert self.change_mode(mode) == dialect.MAV_RESULT_ACCEPTED
        self.run(0.1)
        self.heard.clear()
        self.steering.clear()

    @property
    def mode(self) -> int:
        """The mode, as the firmware's last KITE_STATE or HEARTBEAT told it."""
        for _, message in reversed(self.heard):
            if message.get_type() == "KITE_STATE":
                return message.mode
            if message.get_type() == "HEARTBEAT":
                return message.custom_mode
        raise AssertionError("nothing was heard")

    def texts(self) -> list[str]:
        """The STATUSTEXTs heard so far."""
        return [message.text for message in of_kind("STATUSTEXT", [message for _, message in self.heard])]


def of_kind(kind: str, messages: list[Any]) -> list[Any]:
    """The messages whose type is `kind`."""
    return [message for message in messages if message.get_type() == kind]


def set_parameter(name: str, value: float, system: int = 0) -> dialect.MAVLink_message:
    """PARAM_SET for whoever hears it, or for one `system`."""
    return dialect.MAVLink_param_set_message(system, 1, name.encode(), value, dialect.MAV_PARAM_TYPE_REAL32)


def command_long(command: int, first: float = 0.0, second: float = 0.0, system: int = 1) -> dialect.MAVLink_message:
    """COMMAND_LONG with its first two parameters."""
    return dialect.MAVLink_command_long_message(system, 1, command, 0, first, second, 0.0, 0.0, 0.0, 0.0, 0.0)


def station_heartbeat() -> dialect.MAVLink_message:
    """HEARTBEAT of a ground station."""
    return dialect.MAVLink_heartbeat_message(
        dialect.MAV_TYPE_GCS, dialect.MAV_AUTOPILOT_INVALID, 0, 0, dialect.MAV_STATE_ACTIVE, 3)
