"""Answers what ground stations ask: parameters, commands, time, files."""

from ..mavlink.generated_messages import (
    COMMAND_INT,
    COMMAND_LONG,
    HEARTBEAT,
    KITE_MODE_MANUAL,
    MANUAL_CONTROL,
    MAV_CMD_COMPONENT_ARM_DISARM,
    MAV_CMD_DO_SET_MODE,
    MAV_RESULT_ACCEPTED,
    MAV_RESULT_TEMPORARILY_REJECTED,
    MAV_SEVERITY_WARNING,
    MAV_TYPE_GCS,
    MISSION_COUNT,
    MISSION_REQUEST_LIST,
    PARAM_REQUEST_LIST,
    PARAM_REQUEST_READ,
    PARAM_SET,
    PING,
    RADIO_STATUS,
    TIMESYNC,
)
from ..parameters.generated_parameters import SYSTEM_ID
from ..parameters.values import UNKNOWN
from .command_order import CommandOrder
from .command_requests import CommandRequests
from .curve_requests import CurveRequests
from .file_server import FileServer
from .inbox import disarms, is_safe, sender_of
from .parameter_requests import ParameterRequests

_ORDERS_PER_TICK = 6
_PER_TICK = 8  # orders and questions
_COMPONENT = 1
_COMMANDS = (COMMAND_LONG, COMMAND_INT)
_MOVING = (MAV_CMD_COMPONENT_ARM_DISARM, MAV_CMD_DO_SET_MODE)
_OVERTAKEN = -1  # in the place of a command's message: one that came after it was obeyed before it


class Requests:
    """Handlers by message.

    A request for which the target curve must be checked is put aside for as many ticks as that takes, and those behind
    it go on. Commands put aside are rejected when another that moves the kite comes after them; those that wait, when
    a disarm or PARK does.
    """

    def __init__(self, parameters, modes, kite, turn_k, keeper, link, telemetry):
        self._system = parameters.values  # looked up at each request: it may change
        self._modes = modes
        self._keeper = keeper
        self._link = link
        self._parameters = ParameterRequests(parameters, modes, link, telemetry.say)
        self._commands = CommandRequests(
            parameters, modes, keeper, link, telemetry, self._parameters.announce
        )
        self._curve = CurveRequests(parameters, kite, turn_k)
        self._order = CommandOrder()
        self._say = telemetry.say
        self._files = FileServer(link)
        self._now = 0
        self._uptime_us = 0
        self._handlers = {
            HEARTBEAT: self._on_heartbeat,
            PARAM_REQUEST_LIST: self._on_param_request_list,
            PARAM_REQUEST_READ: self._on_param_request_read,
            PARAM_SET: self._on_param_set,
            _OVERTAKEN: self._on_overtaken,
            MANUAL_CONTROL: self._on_manual_control,
            MISSION_REQUEST_LIST: self._on_mission_request_list,
            RADIO_STATUS: self._on_radio_status,
            TIMESYNC: self._on_timesync,
            PING: self._on_ping,
        }

    def serve(self, inbox, now, uptime_us):
        """Answer the oldest requests of `inbox`, a fixed number at most, and go on with lists, checks and files."""
        self._now = now
        self._uptime_us = uptime_us
        moved = 0
        for request, before in inbox.take_urgent():
            if self._is_for_the_ground(request) and inbox.orders.put(request, before + moved):
                moved += 1
                continue
            self._overtake(inbox.orders.requests, before + moved, request)
            self._handle(inbox, request)
        orders = min(_ORDERS_PER_TICK, len(inbox.orders.requests))
        for _ in range(orders):
            self._handle(inbox, inbox.orders.take())
        for _ in range(min(_PER_TICK - orders, len(inbox.questions.requests))):
            if not self._link.budget.has_answer_room():
                break
            self._handle(inbox, inbox.questions.take_fairly())
        self._check_curve()
        self._commands.send_some()
        self._parameters.send_some()
        self._files.serve(inbox.files, self._for_us)

    def _handle(self, inbox, request):
        message, values, system, component, _ = request
        moves = self._moves(request)
        if moves and self._is_late(request):
            self._say(MAV_SEVERITY_WARNING, "overtaken by a later command")
            self._on_overtaken(values, system, component)
            return
        needs_curve = self._needs_curve(request)
        if moves and not needs_curve and self._curve.commands_wait():
            if self._modes.armed() or disarms(values):
                self._overtake_waiting()
            else:
                needs_curve = True  # it may be for the arming before it, which waits
        if needs_curve:
            if not self._curve.put(request):
                inbox.refused += 1
                if message != PARAM_SET:
                    self._commands.acknowledge(values[7], MAV_RESULT_TEMPORARILY_REJECTED, system, component)
            return
        if message in _COMMANDS:
            if self._for_us(values[8], values[9]):
                self._run(request, None)
            return
        handler = self._handlers.get(message)
        if handler is not None:
            handler(values, system, component)

    def _moves(self, request):
        """True for a command to this kite that arms, disarms or changes the mode."""
        message, values, _, _, _ = request
        return message in _COMMANDS and values[7] in _MOVING and self._for_us(values[8], values[9])

    def _is_late(self, request):
        """True for a late copy of a command that moves the kite; what only asks for what is so is none."""
        _, values, _, _, sequence = request
        if self._commands.is_so(values):
            return False
        what = _what(values)
        is_safe_one = is_safe(values) or what == (MAV_CMD_DO_SET_MODE, KITE_MODE_MANUAL)
        return self._order.is_late(sender_of(request), sequence, what, is_safe_one, self._uptime_us)

    def _run(self, request, problem):
        """Do what a command asks for; `problem` is what speaks against flying the curve, or None."""
        _, values, system, component, sequence = request
        result = self._commands.run(values, problem, system, component, self._now, self._uptime_us)
        if result == MAV_RESULT_ACCEPTED and self._moves(request):
            self._order.note(sender_of(request), sequence, _what(values), self._uptime_us)

    def _needs_curve(self, request):
        message, values, _, _, _ = request
        if message == PARAM_SET:
            return self._for_us(values[1], values[2]) and self._parameters.changes_curve(values[3], values[0]) >= 0
        if message in _COMMANDS:
            return self._for_us(values[8], values[9]) and self._commands.needs_curve(values)
        return False

    def _check_curve(self):
        """Go on with the check for the request whose turn it is, and do what it asks for when that is through."""
        request = self._curve.next()
        if request is None:
            return
        message, values, system, component, _ = request
        if self._needs_curve(request):  # it may not any more: another mode, an earlier copy
            index = self._parameters.changes_curve(values[3], values[0]) if message == PARAM_SET else UNKNOWN
            if not self._curve.advance(index, values[0]):
                return
            problem = self._curve.end()
        else:
            self._curve.end()
            problem = None
        if message == PARAM_SET:
            self._parameters.set(values[3], values[0], problem, system, component)
        else:
            self._run(request, problem)

    def _is_for_the_ground(self, request):
        """True for a PARK while the kite is not armed: not urgent, its turn comes behind an ARM before it."""
        return not self._modes.armed() and self._moves(request) and not disarms(request[1])

    def _overtake(self, orders, before, request):
        """Reject the commands that came before a disarm or PARK and would undo it."""
        if not self._moves(request):
            return
        self._overtake_waiting()
        for index in range(before):
            _, values, system, component, sequence = orders[index]
            if self._moves(orders[index]) and not is_safe(values):
                orders[index] = (_OVERTAKEN, values, system, component, sequence)

    def _overtake_waiting(self):
        """Reject the commands that wait for the curve's check."""
        for request in self._curve.take_commands():
            _, values, system, component, sequence = request
            self._order.note(sender_of(request), sequence, _what(values), self._uptime_us)
            self._on_overtaken(values, system, component)

    def _for_us(self, system, component):
        return system in (0, int(self._system[SYSTEM_ID])) and component in (0, _COMPONENT)

    def _on_heartbeat(self, values, system, component):
        if values[1] == MAV_TYPE_GCS:
            self._modes.hear_station()
            self._keeper.greet(system)

    def _on_param_request_list(self, values, system, component):
        if self._for_us(values[0], values[1]):
            self._parameters.list_all()

    def _on_param_request_read(self, values, system, component):
        if self._for_us(values[1], values[2]):
            self._parameters.read(values[0], values[3], system, component)

    def _on_param_set(self, values, system, component):
        if self._for_us(values[1], values[2]):
            self._parameters.set(values[3], values[0], None, system, component)

    def _on_overtaken(self, values, system, component):
        if self._for_us(values[8], values[9]):
            self._commands.acknowledge(values[7], MAV_RESULT_TEMPORARILY_REJECTED, system, component)

    def _on_manual_control(self, values, system, component):
        if values[5] in (0, int(self._system[SYSTEM_ID])) and -1000 <= values[1] <= 1000:
            self._modes.hear_manual(values[1] * 0.001)

    def _on_mission_request_list(self, values, system, component):
        target_system, target_component, mission_type = values
        if self._for_us(target_system, target_component):
            self._link.answer(MISSION_COUNT, (0, system, component, mission_type))

    def _on_radio_status(self, values, system, component):
        self._link.budget.hear_radio(values[4])

    def _on_timesync(self, values, system, component):
        if values[0] == 0:
            self._link.answer(TIMESYNC, (self._uptime_us * 1000 or 1, values[1]))  # 0 would be a question

    def _on_ping(self, values, system, component):
        time_usec, sequence, target_system, target_component = values
        if target_system == 0 and target_component == 0:
            self._link.answer(PING, (time_usec, sequence, system, component))


def _what(values):
    """What a command that moves the kite asks for."""
    return values[7], values[1] if values[7] == MAV_CMD_DO_SET_MODE else values[0]
