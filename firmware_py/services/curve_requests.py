"""Requests that wait for the check of the target curve, which takes several ticks, while others proceed."""

from ..control.figure_eight import CURVE_PARAMETERS, CurveCheck
from ..generated_enums import KITE_VALID_DISTANCE
from ..parameters.generated_parameters import LINE_LENGTH, TURN_K
from .inbox import first_of_another
from .request import Command

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

    from ..estimation.estimator import Estimator
    from ..estimation.turn_k_estimate import TurnKEstimate
    from ..parameters.values import Parameters
    from .request import ParameterSet

_COMMANDS = 8  # type: Final  # some stations send each over two or three links
_SETS = 2 * len(CURVE_PARAMETERS)  # type: Final
_TRIES = 4  # type: Final
_RESTLESS = "eight changes too often to be checked"  # type: Final


class CurveRequests:
    """One check at a time: commands first, then parameters, of the senders in turn.

    A sender's newer value takes the place of an older one that still waits. The eight is checked for the kite that is
    flown: with the K that was found in flight where that is in use.
    """

    def __init__(self, parameters: "Parameters", kite: "Estimator", turn_k: "TurnKEstimate") -> None:
        self._parameters = parameters
        self._kite = kite
        self._turn_k = turn_k
        self._check = CurveCheck()
        self._commands: list[Command] = []
        self._sets: "list[ParameterSet]" = []
        self._current: "Command | ParameterSet | None" = None  # the request, as in the inbox's queues
        self._curve: list[float] | None = None  # what the check began with
        self._tries: int = 0
        self._last: int = -1  # sender of the set that was checked last

    def put(self, request: "Command | ParameterSet") -> bool:
        """Take a request in; False if there is no room."""
        if isinstance(request, Command):
            if len(self._commands) + self._looks_at_command() >= _COMMANDS:
                return False
            self._commands.append(request)
            return True
        for index in range(len(self._sets)):
            other = self._sets[index]
            if other.name == request.name and other.sender == request.sender:
                self._sets[index] = request
                return True
        if len(self._sets) >= _SETS:
            return False
        self._sets.append(request)
        return True

    def next(self) -> "Command | ParameterSet | None":
        """The request to look at now, or None."""
        if self._current is None:
            self._current = self._commands.pop(0) if self._commands else self._next_set()
        return self._current

    def advance(self, index: int, value: float | None) -> bool:
        """Go on with the check for the present request; True when it is done.

        With parameter `index` at `value`, which is None for a command.
        """
        check = self._check
        if self._curve is None:
            self._begin(index, value)
        check.advance()
        if check.done and self._curve != self._values():
            self._tries += 1
            if self._tries >= _TRIES:
                check.problem = _RESTLESS
                return True
            self._begin(index, value)
        return check.done

    def end(self) -> str | None:
        """Forget the present request; return what the check found, or None."""
        problem = self._check.problem if self._curve is not None else None
        self._current = self._curve = None
        self._tries = 0
        return problem

    def is_busy(self) -> bool:
        """True while any request waits, or is looked at."""
        return bool(self._commands or self._sets) or self._current is not None

    def commands_wait(self) -> bool:
        """True while a command waits, or is looked at."""
        return bool(self._commands) or self._looks_at_command()

    def holds(self, command: Command) -> bool:
        """True for a copy of a command that waits, or is looked at."""
        current = self._current
        if isinstance(current, Command) and current.is_copy_of(command):
            return True
        return any(other.is_copy_of(command) for other in self._commands)

    def take_commands(self) -> list[Command]:
        """Take all commands out; return them."""
        commands = self._commands
        self._commands = []
        current = self._current
        if isinstance(current, Command):
            commands.insert(0, current)
            self.end()
        return commands

    def _looks_at_command(self) -> bool:
        return isinstance(self._current, Command)

    def _next_set(self) -> "ParameterSet | None":
        sets = self._sets
        if not sets:
            return None
        request = sets.pop(first_of_another(sets, self._last))
        self._last = request.sender
        return request

    def _begin(self, index: int, value: float | None) -> None:
        self._curve = self._values()
        values = list(self._parameters.values)
        if value is not None:
            values[index] = value
        if self._turn_k.in_use and index != TURN_K:
            values[TURN_K] = self._turn_k.value
        measured = self._kite.valid & KITE_VALID_DISTANCE
        self._check.begin(values, self._kite.distance if measured else values[LINE_LENGTH])

    def _values(self) -> list[float]:
        """The parameters of the present curve."""
        values = self._parameters.values
        return [values[index] for index in CURVE_PARAMETERS]
