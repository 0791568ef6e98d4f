"""Commands to the vehicle: arm, disarm, change mode. A command is done when the vehicle's heartbeat confirms it."""

from collections.abc import Callable

from ground.errors import NoAnswerError, VehicleError
from ground.link.connection import GROUND_SYSTEM, SILENCE_S, Connection
from ground.link.framing import Message
from ground.vehicle.state import is_armed
from protocol import dialect
from protocol.modes import mode_name

ATTEMPTS = 20
LEAST_INTERVAL_S = 0.5  # heartbeats arrive once a second: more frequent copies would learn nothing new
_REFUSALS = 4  # copies to send in the hope of a reason, if it was lost on the way
_INTERVAL_COPIES = 3
_CONTRADICTIONS = 4  # heartbeats that show another state after the command was accepted

Heartbeat = dialect.MAVLink_heartbeat_message


class Commander:
    """Sends commands over a connection, each until the vehicle's answers leave no doubt.

    The vehicle acknowledges every copy; repeated copies have no further effect. A command is done when a copy was
    accepted and a later heartbeat shows the requested state.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def arm(self) -> None:
        """Arm. Raises VehicleError, with the vehicle's reason, if it refuses; NoAnswerError if it does not answer."""
        self._carry_out("arm", dialect.MAV_CMD_COMPONENT_ARM_DISARM, (1.0, 0.0), is_armed)

    def disarm(self) -> None:
        """Disarm. Raises VehicleError as `arm` does."""
        self._carry_out("disarm", dialect.MAV_CMD_COMPONENT_ARM_DISARM, (0.0, 0.0), lambda beat: not is_armed(beat))

    def set_mode(self, mode: int) -> None:
        """Change to `mode`, a KITE_MODE. Raises VehicleError as `arm` does."""
        flag = float(dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED)
        self._carry_out(f"mode {mode_name(mode)}", dialect.MAV_CMD_DO_SET_MODE, (flag, float(mode)),
                        lambda beat: beat.custom_mode == mode)

    def ask_interval(self, message: int, interval_us: float) -> None:
        """Request `message` every `interval_us` [us], 0 for its default. Does not wait for an acknowledgement."""
        for attempt in range(_INTERVAL_COPIES):
            self._send(dialect.MAV_CMD_SET_MESSAGE_INTERVAL, (float(message), interval_us), attempt)

    def _carry_out(self, what: str, command: int, values: tuple[float, float],
                   shows: Callable[[Heartbeat], bool]) -> None:
        answers = _Answers(command, shows)
        self._connection.add_observer(answers.observe)
        try:
            started_s = self._connection.clock()
            for attempt in range(ATTEMPTS):
                self._send(command, values, attempt)
                wait_s = max(self._connection.round_trip.timeout_s, LEAST_INTERVAL_S)
                if self._connection.wait_until(lambda: answers.settled, wait_s):
                    break
                if self._connection.silence_s(started_s) >= SILENCE_S:
                    break
        finally:
            self._connection.remove_observer(answers.observe)
        if answers.done:
            return
        elapsed_s = self._connection.clock() - started_s
        if not answers.heard:
            why = self._connection.why_silent(started_s)
            raise NoAnswerError(f"{what}: unknown whether it took effect: {why}")
        raise VehicleError(f"{what}: {answers.summary(elapsed_s)}")

    def _send(self, command: int, values: tuple[float, float], attempt: int) -> None:
        system, component = self._connection.target
        self._connection.send(dialect.MAVLink_command_long_message(
            system, component, command, attempt, *values, 0.0, 0.0, 0.0, 0.0, 0.0))


class _Answers:
    """The vehicle's answers while one command is being repeated."""

    def __init__(self, command: int, shows: Callable[[Heartbeat], bool]) -> None:
        self.done = False
        self._command, self._shows = command, shows
        self._accepted = 0
        self._refusals: list[int] = []
        self._reason: str | None = None
        self._contradictions = 0
        self._state = ""

    @property
    def heard(self) -> bool:
        """Whether the vehicle answered at all."""
        return bool(self._accepted or self._refusals)

    @property
    def settled(self) -> bool:
        refused = bool(self._refusals) and (self._reason is not None or len(self._refusals) >= _REFUSALS)
        return self.done or refused or self._contradictions >= _CONTRADICTIONS

    def observe(self, time_s: float, message: Message, frame: bytes) -> None:
        """Evaluate a message of the vehicle, as an observer of the connection."""
        if isinstance(message, dialect.MAVLink_command_ack_message):
            self._acknowledged(message)
        elif isinstance(message, dialect.MAVLink_statustext_message):
            if message.severity <= dialect.MAV_SEVERITY_WARNING:
                self._reason = message.text
        elif isinstance(message, Heartbeat) and self._accepted:
            self._state = f"{mode_name(message.custom_mode)}, {'armed' if is_armed(message) else 'disarmed'}"
            self.done = self.done or self._shows(message)
            self._contradictions += not self.done

    def summary(self, elapsed_s: float) -> str:
        """Why the command was not done, in words."""
        reason = f": {self._reason}" if self._reason else ""
        if self._refusals:
            result = dialect.enums["MAV_RESULT"].get(self._refusals[-1])
            name = result.name.removeprefix("MAV_RESULT_").lower().replace("_", " ") if result else "refused"
            return f"refused by the kite{reason or f' ({name}), which gave no reason'}"
        if self._accepted and self._state:
            return f"accepted by the kite, but it is {self._state}{reason}"
        return f"accepted by the kite, but no heartbeat confirmed it within {elapsed_s:.0f} s"

    def _acknowledged(self, message: dialect.MAVLink_command_ack_message) -> None:
        if message.command != self._command or message.target_system not in (0, GROUND_SYSTEM):
            return
        if message.result == dialect.MAV_RESULT_ACCEPTED:
            self._accepted += 1
        elif message.result != dialect.MAV_RESULT_IN_PROGRESS:
            self._refusals.append(message.result)
