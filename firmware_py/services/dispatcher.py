"""Answers what ground stations ask: parameters, commands, time, files."""

from ..generated_enums import (
    MAV_RESULT_ACCEPTED,
    MAV_RESULT_TEMPORARILY_REJECTED,
    MAV_SEVERITY_WARNING,
    MAV_TYPE_GCS,
)
from ..mavlink.generated_messages import (
    HEARTBEAT,
    MANUAL_CONTROL,
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
from .parameter_requests import ParameterRequests
from .request import Command, ParameterSet

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Final

    from ..estimation.estimator import Estimator
    from ..estimation.turn_k_estimate import TurnKEstimate
    from ..mavlink.interface import Link
    from ..modes.mode_machine import ModeMachine
    from ..parameters.persistence import Keeper
    from ..parameters.values import Parameters
    from ..timing import Timing
    from .inbox import Inbox
    from .request import Request
    from .telemetry import Telemetry

_ORDERS_PER_TICK = 6  # type: Final
_PER_TICK = 8  # type: Final  # orders and questions
_COMPONENT = 1  # type: Final


class Dispatcher:
    """Handlers by message.

    A request for which the target curve must be checked is put aside for as many ticks as that takes, and those behind
    it go on. Commands put aside are rejected when another that moves the kite comes after them; those that wait, when
    a disarm or PARK does. A late copy of a command does nothing of this.
    """

    def __init__(
        self, parameters: "Parameters", modes: "ModeMachine", kite: "Estimator", turn_k: "TurnKEstimate",
        keeper: "Keeper", link: "Link", telemetry: "Telemetry", timing: "Timing"
    ) -> None:
        self._system: list[float] = parameters.values  # looked up at each request: it may change
        self._modes = modes
        self._keeper = keeper
        self._link = link
        self._parameters = ParameterRequests(parameters, modes, link, telemetry.say)
        self._commands = CommandRequests(
            parameters, modes, keeper, link, telemetry, timing, self._parameters.announce
        )
        self._curve = CurveRequests(parameters, kite, turn_k)
        self._order = CommandOrder()
        self._say: "Callable[[int, str], None]" = telemetry.say
        self._files = FileServer(link)
        self._now: int = 0
        self._uptime_us: int = 0
        self._is_busy: bool = False  # something goes on without a new request
        self._handlers: "dict[int, Callable[[Request], None]]" = {
            HEARTBEAT: self._on_heartbeat,
            PARAM_REQUEST_LIST: self._on_param_request_list,
            PARAM_REQUEST_READ: self._on_param_request_read,
            PARAM_SET: self._on_param_set,
            MANUAL_CONTROL: self._on_manual_control,
            MISSION_REQUEST_LIST: self._on_mission_request_list,
            RADIO_STATUS: self._on_radio_status,
            TIMESYNC: self._on_timesync,
            PING: self._on_ping,
        }

    def serve(self, inbox: "Inbox", now: int, uptime_us: int) -> None:
        """Answer the oldest requests of `inbox`, a fixed number at most, and go on with lists, checks and files."""
        self._now = now
        self._uptime_us = uptime_us
        if not (self._is_busy or inbox.urgent or inbox.orders.requests or inbox.questions.requests or inbox.files):
            return
        moved = 0
        for urgent in inbox.take_urgent():
            command = urgent.command
            if self._is_for_the_ground(command) and inbox.orders.put(command, urgent.before + moved):
                moved += 1
                continue
            if self._moves(command) and not self._is_late(command):
                self._overtake(inbox.orders.requests, urgent.before + moved)
            self._handle(inbox, command)
        orders = min(_ORDERS_PER_TICK, len(inbox.orders.requests))
        for _ in range(orders):
            self._handle(inbox, inbox.orders.take())
        self._check_curve()
        self._parameters.answer_sets()
        for _ in range(min(_PER_TICK - orders, len(inbox.questions.requests))):
            if not self._link.budget.claim_answer_room():
                break
            self._handle(inbox, inbox.questions.take_fairly())
        self._commands.send_some()
        self._parameters.list_some()
        self._files.serve(inbox.files, self._for_us)
        self._is_busy = (
            self._curve.is_busy() or self._parameters.is_busy() or self._commands.is_busy() or self._files.is_busy())

    def _handle(self, inbox: "Inbox", request: "Request") -> None:
        if not isinstance(request, Command):
            self._handle_message(inbox, request)
        elif self._is_for_us(request):
            self._handle_command(inbox, request)

    def _handle_message(self, inbox: "Inbox", request: "Request") -> None:
        if isinstance(request, ParameterSet) and self._sets_curve(request):
            if not self._curve.put(request):
                inbox.refused += 1
            return
        handler = self._handlers.get(request.message)
        if handler is not None:
            handler(request)

    def _handle_command(self, inbox: "Inbox", command: Command) -> None:
        if command.overtaken:
            self._reject(command)
            return
        moves = command.moves()
        if moves:
            if self._is_late(command):
                self._answer_late(command)
                return
            self._modes.hear_operator()
        needs_curve = self._commands.needs_curve(command)
        if moves and not needs_curve and self._curve.commands_wait():
            if self._modes.armed() or command.disarms():
                self._overtake_waiting()
            else:
                needs_curve = True  # it may be for the arming before it, which waits
        if not needs_curve:
            self._run(command, None)
        elif not self._curve.put(command):
            inbox.refused += 1
            if not self._curve.holds(command):  # a copy says nothing of the one that waits
                self._note(command, True)
            self._reject(command)

    def _moves(self, command: Command) -> bool:
        """True for a command to this kite that arms, disarms or changes the mode."""
        return command.moves() and self._is_for_us(command)

    def _is_late(self, command: Command) -> bool:
        """True for a late copy of a command that moves the kite."""
        return self._order.is_late(
            command.sender, command.sequence, command.wish(), command.is_safe(), self._uptime_us)

    def _answer_late(self, command: Command) -> None:
        """A late copy changes nothing: it is accepted where what it asks for is so, and rejected otherwise."""
        if self._commands.is_so(command):
            self._commands.acknowledge(command, MAV_RESULT_ACCEPTED)
            return
        if not self._order.was_refused(command.sender, command.sequence, command.wish()):
            self._say(MAV_SEVERITY_WARNING, "overtaken by a later command")
        self._reject(command)

    def _note(self, command: Command, refused: bool) -> None:
        """Remember a command that moves the kite: a copy of it may come later."""
        self._order.note(command.sender, command.sequence, command.wish(), refused, self._uptime_us)

    def _run(self, command: Command, problem: str | None) -> None:
        """Do what a command asks for; `problem` is what speaks against flying the curve, or None."""
        result = self._commands.run(command, problem, self._now, self._uptime_us)
        if command.moves():
            self._note(command, result != MAV_RESULT_ACCEPTED)

    def _reject(self, command: Command) -> None:
        self._commands.acknowledge(command, MAV_RESULT_TEMPORARILY_REJECTED)

    def _sets_curve(self, request: ParameterSet) -> bool:
        """True for what may be set only when the eight that it makes is known to be one that can be flown."""
        if not self._is_for_us(request):
            return False
        return self._parameters.changes_curve(request.name, request.value) != UNKNOWN

    def _check_curve(self) -> None:
        """Go on with the check for the request whose turn it is, and do what it asks for when that is through."""
        request = self._curve.next()
        if request is None:
            return
        index = UNKNOWN
        value = None
        if isinstance(request, Command):
            if self._is_late(request):  # a copy of one that waited before it
                self._curve.end()
                self._answer_late(request)
                return
            needs_curve = self._commands.needs_curve(request)
        else:
            needs_curve = self._sets_curve(request)
            index = self._parameters.changes_curve(request.name, request.value)
            value = request.value
        if needs_curve and not self._curve.advance(index, value):  # it may not any more: another mode, an earlier copy
            return
        found = self._curve.end()
        problem = found if needs_curve else None
        if isinstance(request, Command):
            self._run(request, problem)
        else:
            self._parameters.set(request, problem)

    def _is_for_the_ground(self, command: Command) -> bool:
        """True for a PARK while the kite is not armed: not urgent, its turn comes behind an ARM before it."""
        return not self._modes.armed() and self._moves(command) and not command.disarms()

    def _overtake(self, orders: "list[Request]", before: int) -> None:
        """Reject the commands that came before a disarm or PARK and would undo it."""
        self._overtake_waiting()
        for request in orders[:before]:
            if not isinstance(request, Command) or not self._moves(request):
                continue
            if not request.is_urgent() and not self._is_late(request):
                self._note(request, False)
                request.overtaken = True

    def _overtake_waiting(self) -> None:
        """Reject the commands that wait for the curve's check."""
        for command in self._curve.take_commands():
            self._note(command, False)
            self._reject(command)

    def _is_for_us(self, request: Command | ParameterSet) -> bool:
        return self._for_us(request.target_system, request.target_component)

    def _for_us(self, system: int, component: int) -> bool:
        return system in (0, int(self._system[SYSTEM_ID])) and component in (0, _COMPONENT)

    def _on_heartbeat(self, request: "Request") -> None:
        _, kind, _, _, _, _ = request.values
        if kind == MAV_TYPE_GCS:
            self._modes.hear_station()
            self._keeper.greet(request.system)

    def _on_param_request_list(self, request: "Request") -> None:
        target_system, target_component = request.values
        if self._for_us(target_system, target_component):
            self._parameters.list_all()

    def _on_param_request_read(self, request: "Request") -> None:
        index, target_system, target_component, name = request.values
        if self._for_us(target_system, target_component):
            self._parameters.read(index, name, request.system, request.component)

    def _on_param_set(self, request: "Request") -> None:
        if isinstance(request, ParameterSet) and self._is_for_us(request):
            self._parameters.set(request, None)

    def _on_manual_control(self, request: "Request") -> None:
        _, y, _, _, _, target_system, *_ = request.values
        if target_system in (0, int(self._system[SYSTEM_ID])) and -1000 <= y <= 1000:
            self._modes.hear_manual(y * 0.001)

    def _on_mission_request_list(self, request: "Request") -> None:
        target_system, target_component, kind = request.values
        if self._for_us(target_system, target_component):
            self._link.answer(MISSION_COUNT, (0, request.system, request.component, kind))

    def _on_radio_status(self, request: "Request") -> None:
        _, _, _, _, free, _, _ = request.values
        self._link.budget.hear_radio(free)

    def _on_timesync(self, request: "Request") -> None:
        answered, asked = request.values
        if answered == 0:
            self._link.answer(TIMESYNC, (self._uptime_us * 1000 or 1, asked))  # 0 would be a question

    def _on_ping(self, request: "Request") -> None:
        time_us, number, target_system, target_component = request.values
        if target_system == 0 and target_component == 0:
            self._link.answer(PING, (time_us, number, request.system, request.component))
