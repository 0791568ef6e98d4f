"""Preflight, before t = 0: load parameters, arm, change to TRACK, by standard messages."""

from math import inf

from protocol import dialect
from protocol.messages import CommandAck, ParamError, ParamValue, Statustext
from protocol.parameter_table import load_parameters
from sim_bridge.errors import FirmwareError
from sim_bridge.links.wire import BRIDGE_COMPONENT, BRIDGE_SYSTEM, as_request
from sim_bridge.runtimes.interface import Message
from sim_bridge.scenario.scenario import Scenario

PREFLIGHT_TICKS = 40  # parameters, arming, checking the curve; and each of them may be asked twice
_ASKED_PER_TICK = 4
_REPEAT_TICKS = 15
_EVERYBODY = 0  # there is one kite on the link, whatever its system id
_US = (BRIDGE_SYSTEM, BRIDGE_COMPONENT)
_TRACK = dialect.KITE_MODE_TRACK
_REFUSALS = {
    dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST: "no such parameter",
    dialect.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE: "out of range",
    dialect.MAV_PARAM_ERROR_READ_ONLY: "read-only",
    dialect.MAV_PARAM_ERROR_PERMISSION_DENIED: "can be set only while disarmed, and a ground station has armed the "
                                               "kite",
}


class Preflight:
    """Repeats its requests until everything is acknowledged; then `done`.

    Answers to ground stations are ignored.
    """

    def __init__(self, scenario: Scenario):
        self._wanted = {
            name: scenario.parameter(name) for name, entry in load_parameters().items()
            if not entry.read_only and (name != "SYSTEM_ID" or name in scenario.parameters)}
        self._asked: dict[str, float] = {}
        self._armed = False
        self._last_command = -inf
        self._reason = "no answer"
        self.done = False

    def requests(self, tick: int) -> list[Message]:
        """The requests of this tick."""
        if self.done:
            return []
        if self._wanted:
            due = [name for name in self._wanted if tick - self._asked.get(name, -inf) >= _REPEAT_TICKS]
            self._asked |= dict.fromkeys(due[:_ASKED_PER_TICK], tick)
            return [self._set(name) for name in due[:_ASKED_PER_TICK]]
        if tick - self._last_command < _REPEAT_TICKS:
            return []
        self._last_command = tick
        if self._armed:
            return [self._command(dialect.MAV_CMD_DO_SET_MODE, 1.0, float(_TRACK))]
        return [self._command(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1.0, 0.0)]

    def hear(self, replies: list[Message]) -> None:
        """Take the firmware's answers; those addressed to somebody else are passed over.

        Raises:
            FirmwareError: a parameter was refused.
        """
        for _, reply in replies:
            if isinstance(reply, ParamValue):  # goes to everybody, and is true for everybody
                name = _text(reply.param_id)
                if self._wanted.get(name) == reply.param_value:
                    del self._wanted[name]
            elif isinstance(reply, ParamError) and (reply.target_system, reply.target_component) == _US:
                why = _REFUSALS.get(reply.error, "no reason")
                raise FirmwareError(f"the firmware refused {_text(reply.param_id)}: {why}")
            elif isinstance(reply, Statustext) and reply.severity <= dialect.MAV_SEVERITY_WARNING:
                self._reason = _text(reply.text)
            elif isinstance(reply, CommandAck) and (reply.target_system, reply.target_component) == _US:
                self._acknowledge(reply.command, reply.result)

    def check(self) -> None:
        """At t = 0: everything must have been acknowledged.

        Raises:
            FirmwareError: it was not, with the firmware's reason.
        """
        if self._wanted:
            raise FirmwareError(f"the firmware did not acknowledge {next(iter(self._wanted))}")
        if not self.done:
            raise FirmwareError(f"the firmware refused to {'track' if self._armed else 'arm'}: {self._reason}")

    def _acknowledge(self, command: int, result: int) -> None:
        if result != dialect.MAV_RESULT_ACCEPTED:
            return
        if command == dialect.MAV_CMD_COMPONENT_ARM_DISARM and not self._armed:
            self._armed = True
            self._last_command = -inf
        elif command == dialect.MAV_CMD_DO_SET_MODE:
            self.done = True

    def _set(self, name: str) -> Message:
        kind = dialect.MAV_PARAM_TYPE_REAL32
        return as_request(dialect.MAVLink_param_set_message(
            _EVERYBODY, 0, name.encode(), self._wanted[name], kind))

    def _command(self, command: int, first: float, second: float) -> Message:
        return as_request(dialect.MAVLink_command_long_message(
            _EVERYBODY, 0, command, 0, first, second, 0.0, 0.0, 0.0, 0.0, 0.0))


def _text(value: bytes) -> str:
    return value.rstrip(b"\0").decode(errors="replace")
