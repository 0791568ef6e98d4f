"""Answers what ground stations ask: parameters, commands, time."""

from .generated_messages import (
    AUTOPILOT_VERSION,
    COMMAND_ACK,
    COMMAND_LONG,
    CONTRACT_HASH,
    HEARTBEAT,
    KITE_MODE_TRACK,
    KITE_VALID_DISTANCE,
    MANUAL_CONTROL,
    MAV_CMD_COMPONENT_ARM_DISARM,
    MAV_CMD_DO_SET_MODE,
    MAV_CMD_PREFLIGHT_STORAGE,
    MAV_CMD_REQUEST_MESSAGE,
    MAV_PARAM_ERROR_DOES_NOT_EXIST,
    MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
    MAV_PARAM_TYPE_REAL32,
    MAV_PROTOCOL_CAPABILITY_MAVLINK2,
    MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST,
    MAV_RESULT_ACCEPTED,
    MAV_RESULT_DENIED,
    MAV_RESULT_TEMPORARILY_REJECTED,
    MAV_RESULT_UNSUPPORTED,
    MAV_SEVERITY_WARNING,
    MAV_TYPE_GCS,
    PARAM_ERROR,
    PARAM_REQUEST_LIST,
    PARAM_REQUEST_READ,
    PARAM_SET,
    PARAM_VALUE,
    PING,
    TIMESYNC,
)
from .generated_parameters import LINE_LENGTH, PARAMETERS, SYSTEM_ID
from .parameters import UNKNOWN
from .storage_commands import StorageCommands
from .target_curve import CURVE_PARAMETERS, CurveCheck

FIRMWARE_VERSION = (0, 1, 0)
_PER_TICK = 8  # requests answered in one tick
_LISTED_PER_TICK = 2  # parameters of those that nobody waits for one by one
_COMPONENT = 1
_WAIT = True


class Requests:
    """Handlers by message; `say(severity, text)` tells the operator why something was refused.

    A handler returns _WAIT when the target curve must be checked first, which takes several ticks: the request stays
    at the head of the queue, and those behind it wait too, so that all are answered in the order in which they came.
    """

    def __init__(self, parameters, modes, kite, keeper, link, say):
        self._parameters = parameters
        self._modes = modes
        self._kite = kite
        self._keeper = keeper
        self._storage = StorageCommands(parameters, modes, keeper, say, self._announce)
        self._check = CurveCheck()
        self._checking = False
        self._link = link
        self._say = say
        self._unsent = []  # indices of parameters that are still to be sent, a few a tick
        self._clock_ns = 0
        self._handlers = {
            HEARTBEAT: self._on_heartbeat,
            PARAM_REQUEST_LIST: self._on_param_request_list,
            PARAM_REQUEST_READ: self._on_param_request_read,
            PARAM_SET: self._on_param_set,
            COMMAND_LONG: self._on_command_long,
            MANUAL_CONTROL: self._on_manual_control,
            TIMESYNC: self._on_timesync,
            PING: self._on_ping,
        }

    def serve(self, inbox, now, uptime_us):
        """Answer the oldest requests of `inbox`, a fixed number at most, and go on with a list."""
        self._clock_ns = uptime_us * 1000
        requests = inbox.requests
        for _ in range(min(_PER_TICK, len(requests))):
            message, values, system, component = requests[0]
            handler = self._handlers.get(message)
            if handler is not None and handler(values, system, component, now) is _WAIT:
                break
            requests.pop(0)
            self._checking = False
        for _ in range(min(_LISTED_PER_TICK, len(self._unsent))):
            self._send_parameter(self._unsent.pop(0))

    def _for_us(self, system, component):
        return system in (0, int(self._parameters.values[SYSTEM_ID])) and component in (0, _COMPONENT)

    def _on_heartbeat(self, values, system, component, now):
        if values[1] == MAV_TYPE_GCS:
            self._modes.hear_station(now)
            self._keeper.greet(system)

    def _on_param_request_list(self, values, system, component, now):
        if self._for_us(values[0], values[1]):
            self._unsent = list(range(len(PARAMETERS)))

    def _on_param_request_read(self, values, system, component, now):
        index, target_system, target_component, name = values
        if not self._for_us(target_system, target_component):
            return
        if index < 0:
            index = self._parameters.index_of(name)
        if 0 <= index < len(PARAMETERS):
            self._send_parameter(index)
        else:
            self._refuse_parameter(values[0], name, MAV_PARAM_ERROR_DOES_NOT_EXIST, system, component)

    def _on_param_set(self, values, system, component, now):
        value, target_system, target_component, name, _ = values
        if not self._for_us(target_system, target_component):
            return None
        parameters = self._parameters
        index = parameters.index_of(name)
        error = parameters.refusal(index, value, self._modes.armed())
        flown = self._modes.mode == KITE_MODE_TRACK
        if not error and flown and index in CURVE_PARAMETERS and parameters.values[index] != value:
            if not self._checked(index, value):
                return _WAIT
            if self._check.problem is not None:
                error = MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE
                self._say(MAV_SEVERITY_WARNING, self._check.problem)
        if error:
            self._refuse_parameter(-1, name, error, system, component)
        else:
            parameters.set(index, value)
        if index != UNKNOWN:
            self._send_parameter(index)
        return None

    def _checked(self, index=UNKNOWN, value=0.0):
        """Go on with the check of the target curve, with parameter `index` at `value`; True when it is done."""
        if not self._checking:
            values = list(self._parameters.values)
            if index != UNKNOWN:
                values[index] = value
            measured = self._kite.valid & KITE_VALID_DISTANCE
            self._check.begin(values, self._kite.distance if measured else values[LINE_LENGTH])
        self._check.advance()
        self._checking = not self._check.done
        return self._check.done

    def _send_parameter(self, index):
        parameters = self._parameters
        name = parameters.name_of(index)
        self._link.send(
            PARAM_VALUE, (parameters.values[index], len(PARAMETERS), index, name, MAV_PARAM_TYPE_REAL32)
        )

    def _announce(self, index):
        if index not in self._unsent:
            self._unsent.append(index)

    def _refuse_parameter(self, index, name, error, system, component):
        self._link.send(PARAM_ERROR, (index, system, component, name, error))

    def _on_command_long(self, values, system, component, now):
        command = values[7]
        if not self._for_us(values[8], values[9]):
            return None
        if self._needs_curve(command, values) and not self._checked():
            return _WAIT
        if command == MAV_CMD_COMPONENT_ARM_DISARM:
            result = self._arm_or_disarm(values[0], now)
        elif command == MAV_CMD_DO_SET_MODE:
            result = self._set_mode(values[1], now)
        elif command == MAV_CMD_PREFLIGHT_STORAGE:
            result = self._storage.run(values[0])
        elif command == MAV_CMD_REQUEST_MESSAGE:
            result = MAV_RESULT_ACCEPTED if values[0] == AUTOPILOT_VERSION else MAV_RESULT_UNSUPPORTED
        else:
            result = MAV_RESULT_UNSUPPORTED
        self._link.send(COMMAND_ACK, (command, result, 0, 0, system, component))
        if command == MAV_CMD_REQUEST_MESSAGE and result == MAV_RESULT_ACCEPTED:
            self._send_version()
        return None

    def _needs_curve(self, command, values):
        """True for a command that may have the curve flown: arming, and TRACK from another mode."""
        if command == MAV_CMD_COMPONENT_ARM_DISARM:
            return values[0] == 1.0 and not self._modes.armed()
        return command == MAV_CMD_DO_SET_MODE and values[1] == KITE_MODE_TRACK != self._modes.mode

    def _arm_or_disarm(self, wanted, now):
        if wanted == 1.0:
            reason = self._modes.arm(now, self._check.problem)
            if reason is not None:
                self._say(MAV_SEVERITY_WARNING, reason)
                return MAV_RESULT_TEMPORARILY_REJECTED
        elif wanted == 0.0:
            self._modes.disarm()
        else:
            return MAV_RESULT_DENIED
        return MAV_RESULT_ACCEPTED

    def _set_mode(self, mode, now):
        if not 0.0 <= mode <= 255.0 or mode % 1.0:
            return MAV_RESULT_DENIED
        reason = self._modes.command(int(mode), now, self._check.problem)
        if reason is None:
            return MAV_RESULT_ACCEPTED
        self._say(MAV_SEVERITY_WARNING, reason)
        return MAV_RESULT_TEMPORARILY_REJECTED

    def _send_version(self):
        major, minor, patch = FIRMWARE_VERSION
        capabilities = MAV_PROTOCOL_CAPABILITY_MAVLINK2 | MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST
        contract = tuple(int(CONTRACT_HASH[2 * index : 2 * index + 2], 16) for index in range(8))
        version = major << 24 | minor << 16 | patch << 8
        none = (0,) * 8
        self._link.send(
            AUTOPILOT_VERSION, (capabilities, 0, version, 0, 0, 0, 0, 0) + none + contract + none + (0,) * 18
        )

    def _on_manual_control(self, values, system, component, now):
        if values[5] in (0, int(self._parameters.values[SYSTEM_ID])) and -1000 <= values[1] <= 1000:
            self._modes.hear_manual(values[1] * 0.001, now)

    def _on_timesync(self, values, system, component, now):
        if values[0] == 0:
            self._link.send(TIMESYNC, (self._clock_ns or 1, values[1]))  # 0 would be a question

    def _on_ping(self, values, system, component, now):
        time_usec, sequence, target_system, target_component = values
        if target_system == 0 and target_component == 0:
            self._link.send(PING, (time_usec, sequence, system, component))
