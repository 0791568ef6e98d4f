"""Commands: each copy is acknowledged to its sender, and only the first changes anything."""

from ..generated_enums import (
    KITE_MODE_TRACK,
    MAV_CMD_COMPONENT_ARM_DISARM,
    MAV_CMD_DO_SET_MODE,
    MAV_CMD_GET_MESSAGE_INTERVAL,
    MAV_CMD_PREFLIGHT_STORAGE,
    MAV_CMD_REQUEST_MESSAGE,
    MAV_CMD_SET_MESSAGE_INTERVAL,
    MAV_RESULT_ACCEPTED,
    MAV_RESULT_DENIED,
    MAV_RESULT_FAILED,
    MAV_RESULT_TEMPORARILY_REJECTED,
    MAV_RESULT_UNSUPPORTED,
    MAV_SEVERITY_WARNING,
)
from ..mavlink.generated_messages import COMMAND_ACK
from .inbox import Queue
from .message_requests import MessageRequests
from .request import Request

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Final

    from ..mavlink.interface import Link
    from ..modes.mode_machine import ModeMachine
    from ..parameters.persistence import Keeper
    from ..parameters.values import Parameters
    from ..timing import Timing
    from .request import Command
    from .telemetry import Telemetry

_ROOM = 16  # type: Final  # acknowledgements that wait
_READ = 0.0  # type: Final  # param1 of MAV_CMD_PREFLIGHT_STORAGE
_WRITE = 1.0  # type: Final
_RESET = 2.0  # type: Final


class CommandRequests:
    """What each Command does, and its acknowledgement."""

    def __init__(
        self, parameters: "Parameters", modes: "ModeMachine", keeper: "Keeper", link: "Link", telemetry: "Telemetry",
        timing: "Timing", announce: "Callable[[int], None]"
    ) -> None:
        self._modes = modes
        self._timing = timing
        self._link = link
        self._say: "Callable[[int, str], None]" = telemetry.say
        self._storage = StorageCommands(parameters, modes, keeper, telemetry.say, announce)
        self._messages = MessageRequests(link, telemetry)
        self._acknowledgements = Acknowledgements(link)

    def needs_curve(self, command: "Command") -> bool:
        """True for a command that may have the curve flown: arming, and TRACK from another mode."""
        if command.command == MAV_CMD_COMPONENT_ARM_DISARM:
            return command.param1 == 1.0 and not self._modes.armed()
        return command.command == MAV_CMD_DO_SET_MODE and command.param2 == KITE_MODE_TRACK != self._modes.mode

    def is_so(self, command: "Command") -> bool:
        """True for a command that arms, disarms or changes the mode, where what it asks for is so already."""
        if command.command == MAV_CMD_COMPONENT_ARM_DISARM:
            return self._modes.armed() == (command.param1 == 1.0)
        return command.param2 == self._modes.mode

    def run(self, command: "Command", problem: str | None, now: int, uptime_us: int) -> int:
        """Do it, acknowledge it, return the MAV_RESULT; `problem` speaks against flying the curve, or is None."""
        asked = command.command
        accepted = MAV_RESULT_ACCEPTED
        if asked == MAV_CMD_COMPONENT_ARM_DISARM:
            result = self._arm_or_disarm(command.param1, problem)
        elif asked == MAV_CMD_DO_SET_MODE:
            result = self._set_mode(command.param2, problem)
        elif asked == MAV_CMD_PREFLIGHT_STORAGE:
            result = self._storage.run(command.param1)
        elif asked == MAV_CMD_REQUEST_MESSAGE:
            result = self._messages.result(command.param1, command.param2)
        elif asked == MAV_CMD_SET_MESSAGE_INTERVAL:
            result = self._messages.set_interval(command.param1, command.param2)
        else:
            result = accepted if asked == MAV_CMD_GET_MESSAGE_INTERVAL else MAV_RESULT_UNSUPPORTED
        self.acknowledge(command, result)
        if asked == MAV_CMD_REQUEST_MESSAGE and result == accepted:
            self._messages.send(command.param1, command.param2, now, uptime_us)
        elif asked == MAV_CMD_GET_MESSAGE_INTERVAL:
            self._messages.send_interval(command.param1)
        return result

    def acknowledge(self, command: "Command", result: int) -> None:
        """Send COMMAND_ACK, when there is room for it; to what only asks, as a part of the answer."""
        values = (command.command, result, 0, 0, command.system, command.component)
        if command.changes():
            self._acknowledgements.put(Request(COMMAND_ACK, values, command.system, command.component))
        else:
            self._link.answer(COMMAND_ACK, values)

    def is_busy(self) -> bool:
        """True while something waits for room on the link."""
        return self._acknowledgements.is_busy() or self._messages.is_busy()

    def send_some(self) -> None:
        """Go on with what waits for room on the link."""
        self._acknowledgements.send_some()
        self._messages.send_some()

    def _arm_or_disarm(self, wanted: float, problem: str | None) -> int:
        if wanted == 1.0:
            reason = self._modes.arm(problem or self._timing.problem())
            if reason is not None:
                self._say(MAV_SEVERITY_WARNING, reason)
                return MAV_RESULT_TEMPORARILY_REJECTED
        elif wanted == 0.0:
            self._modes.disarm()
        else:
            return MAV_RESULT_DENIED
        return MAV_RESULT_ACCEPTED

    def _set_mode(self, mode: float, problem: str | None) -> int:
        if not 0.0 <= mode <= 255.0 or mode % 1.0:
            return MAV_RESULT_DENIED
        reason = self._modes.command(int(mode), problem)
        if reason is None:
            return MAV_RESULT_ACCEPTED
        self._say(MAV_SEVERITY_WARNING, reason)
        return MAV_RESULT_TEMPORARILY_REJECTED


class Acknowledgements:
    """On their way out, as many as the link's budget has room for, the rest in their turn.

    Bounded, and fair between senders; what finds no place is forgotten: its station asks again.
    """

    def __init__(self, link: "Link") -> None:
        self._link = link
        self._queue = Queue(_ROOM)

    def put(self, request: "Request") -> None:
        """Take one in, as a Request to send."""
        self._queue.put(request)
        self.send_some()

    def is_busy(self) -> bool:
        """True while something waits."""
        return bool(self._queue.requests)

    def send_some(self) -> None:
        """Send what waits, while there is room."""
        budget = self._link.budget
        while self._queue.requests and budget.claim_acknowledgement_room():
            request = self._queue.take_fairly()
            budget.spend_on_acknowledgement(self._link.send(COMMAND_ACK, request.values))


class StorageCommands:
    """MAV_CMD_PREFLIGHT_STORAGE over a `keeper`: read, write and reset what is on flash.

    `announce(index)` is called for each parameter that a command changed.
    """

    def __init__(
        self, parameters: "Parameters", modes: "ModeMachine", keeper: "Keeper", say: "Callable[[int, str], None]",
        announce: "Callable[[int], None]"
    ) -> None:
        self._parameters = parameters
        self._modes = modes
        self._keeper = keeper
        self._say: "Callable[[int, str], None]" = say
        self._announce = announce

    def run(self, action: float) -> int:
        """Do what param1 of the command asks for; return the MAV_RESULT."""
        if action not in (_READ, _WRITE, _RESET):
            return MAV_RESULT_DENIED
        if self._keeper.store is None:
            self._say(MAV_SEVERITY_WARNING, "no storage on this board")
            return MAV_RESULT_TEMPORARILY_REJECTED
        if self._modes.armed():
            self._say(MAV_SEVERITY_WARNING, "disarm first")
            return MAV_RESULT_TEMPORARILY_REJECTED
        before = list(self._parameters.values)
        if action == _READ:
            done = self._keeper.read_back()
        elif action == _WRITE:
            done = self._keeper.save()
        else:
            done = self._keeper.reset()
        for index in range(len(before)):
            if self._parameters.values[index] != before[index]:
                self._announce(index)
        return MAV_RESULT_ACCEPTED if done else MAV_RESULT_FAILED
