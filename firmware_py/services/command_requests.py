"""Commands: each copy that comes is acknowledged to whoever sent it, and a copy changes nothing that the first did."""

from ..mavlink.generated_messages import (
    COMMAND_ACK,
    KITE_MODE_TRACK,
    MAV_CMD_COMPONENT_ARM_DISARM,
    MAV_CMD_DO_SET_MODE,
    MAV_CMD_GET_MESSAGE_INTERVAL,
    MAV_CMD_PREFLIGHT_STORAGE,
    MAV_CMD_REQUEST_MESSAGE,
    MAV_CMD_SET_MESSAGE_INTERVAL,
    MAV_RESULT_ACCEPTED,
    MAV_RESULT_DENIED,
    MAV_RESULT_TEMPORARILY_REJECTED,
    MAV_RESULT_UNSUPPORTED,
    MAV_SEVERITY_WARNING,
)
from .acknowledgements import Acknowledgements
from .inbox import ORDERED
from .message_requests import MessageRequests
from .storage_requests import StorageCommands


class CommandRequests:
    """Takes the values of COMMAND_LONG or COMMAND_INT, which lie alike up to the targets."""

    def __init__(self, parameters, modes, keeper, link, telemetry, announce):
        self._modes = modes
        self._link = link
        self._say = telemetry.say
        self._storage = StorageCommands(parameters, modes, keeper, telemetry.say, announce)
        self._messages = MessageRequests(link, telemetry)
        self._acknowledgements = Acknowledgements(link)

    def needs_curve(self, values):
        """True for a command that may have the curve flown: arming, and TRACK from another mode."""
        if values[7] == MAV_CMD_COMPONENT_ARM_DISARM:
            return values[0] == 1.0 and not self._modes.armed()
        return values[7] == MAV_CMD_DO_SET_MODE and values[1] == KITE_MODE_TRACK != self._modes.mode

    def is_so(self, values):
        """True for a command that arms, disarms or changes the mode, where what it asks for is so already."""
        if values[7] == MAV_CMD_COMPONENT_ARM_DISARM:
            return self._modes.armed() == (values[0] == 1.0)
        return values[1] == self._modes.mode

    def run(self, values, problem, system, component, now, uptime_us):
        """Do it, acknowledge it, return the MAV_RESULT; `problem` speaks against flying the curve, or is None."""
        command = values[7]
        accepted = MAV_RESULT_ACCEPTED
        if command == MAV_CMD_COMPONENT_ARM_DISARM:
            result = self._arm_or_disarm(values[0], problem)
        elif command == MAV_CMD_DO_SET_MODE:
            result = self._set_mode(values[1], problem)
        elif command == MAV_CMD_PREFLIGHT_STORAGE:
            result = self._storage.run(values[0])
        elif command == MAV_CMD_REQUEST_MESSAGE:
            result = self._messages.result(values[0], values[1])
        elif command == MAV_CMD_SET_MESSAGE_INTERVAL:
            result = self._messages.set_interval(values[0], values[1])
        else:
            result = accepted if command == MAV_CMD_GET_MESSAGE_INTERVAL else MAV_RESULT_UNSUPPORTED
        self.acknowledge(command, result, system, component)
        if command == MAV_CMD_REQUEST_MESSAGE and result == accepted:
            self._messages.send(values[0], values[1], now, uptime_us)
        elif command == MAV_CMD_GET_MESSAGE_INTERVAL:
            self._messages.send_interval(values[0])
        return result

    def acknowledge(self, command, result, system, component):
        """Send COMMAND_ACK, when there is room for it; to what only asks, as a part of the answer."""
        if command in ORDERED:
            self._acknowledgements.put(command, result, system, component)
        else:
            self._link.answer(COMMAND_ACK, (command, result, 0, 0, system, component))

    def send_some(self):
        """Go on with what waits for room on the link."""
        self._acknowledgements.send_some()
        self._messages.send_some()

    def _arm_or_disarm(self, wanted, problem):
        if wanted == 1.0:
            reason = self._modes.arm(problem)
            if reason is not None:
                self._say(MAV_SEVERITY_WARNING, reason)
                return MAV_RESULT_TEMPORARILY_REJECTED
        elif wanted == 0.0:
            self._modes.disarm()
        else:
            return MAV_RESULT_DENIED
        return MAV_RESULT_ACCEPTED

    def _set_mode(self, mode, problem):
        if not 0.0 <= mode <= 255.0 or mode % 1.0:
            return MAV_RESULT_DENIED
        reason = self._modes.command(int(mode), problem)
        if reason is None:
            return MAV_RESULT_ACCEPTED
        self._say(MAV_SEVERITY_WARNING, reason)
        return MAV_RESULT_TEMPORARILY_REJECTED
