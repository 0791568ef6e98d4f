"""Requests that wait for the check of the target curve, which takes several ticks, while others proceed."""

from ..control.figure_eight import CURVE_PARAMETERS, CurveCheck
from ..generated_enums import KITE_VALID_DISTANCE
from ..mavlink.generated_messages import PARAM_SET
from ..parameters.generated_parameters import LINE_LENGTH, TURN_K
from ..parameters.values import UNKNOWN
from .inbox import first_of_another

_COMMANDS = 8  # some stations send each over two or three links
_SETS = 2 * len(CURVE_PARAMETERS)
_TRIES = 4
_RESTLESS = "eight changes too often to be checked"


class CurveRequests:
    """One check at a time: commands first, then parameters, of the senders in turn.

    A sender's newer value takes the place of an older one that still waits. The eight is checked for the kite that is
    flown: with the K that was found in flight where that is in use.
    """

    def __init__(self, parameters, kite, turn_k):
        self._parameters = parameters
        self._kite = kite
        self._turn_k = turn_k
        self._check = CurveCheck()
        self._commands = []
        self._sets = []
        self._current = None  # the request, as in the inbox's queues
        self._curve = None  # what the check began with
        self._tries = 0
        self._last = -1  # sender of the set that was checked last

    def put(self, request):
        """Take a request in; False if there is no room."""
        if request.message != PARAM_SET:
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

    def next(self):
        """The request to look at now, or None."""
        if self._current is None:
            self._current = self._commands.pop(0) if self._commands else self._next_set()
        return self._current

    def advance(self, index, value):
        """Go on with the check for the present request, with parameter `index` at `value`; True when it is done."""
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

    def end(self):
        """Forget the present request; return what the check found, or None."""
        problem = self._check.problem if self._curve is not None else None
        self._current = self._curve = None
        self._tries = 0
        return problem

    def is_busy(self):
        """True while any request waits, or is looked at."""
        return bool(self._commands or self._sets) or self._current is not None

    def commands_wait(self):
        """True while a command waits, or is looked at."""
        return bool(self._commands) or self._looks_at_command()

    def holds(self, command):
        """True for a copy of a command that waits, or is looked at."""
        waiting = self._commands + ([self._current] if self._looks_at_command() else [])
        return any(other.is_copy_of(command) for other in waiting)

    def take_commands(self):
        """Take all commands out; return them."""
        commands = self._commands
        self._commands = []
        if self._looks_at_command():
            commands.insert(0, self._current)
            self.end()
        return commands

    def _looks_at_command(self):
        return self._current is not None and self._current.message != PARAM_SET

    def _next_set(self):
        sets = self._sets
        if not sets:
            return None
        request = sets.pop(first_of_another(sets, self._last))
        self._last = request.sender
        return request

    def _begin(self, index, value):
        self._curve = self._values()
        values = list(self._parameters.values)
        if index != UNKNOWN:
            values[index] = value
        if self._turn_k.in_use and index != TURN_K:
            values[TURN_K] = self._turn_k.value
        measured = self._kite.valid & KITE_VALID_DISTANCE
        self._check.begin(values, self._kite.distance if measured else values[LINE_LENGTH])

    def _values(self):
        """The parameters of the present curve."""
        values = self._parameters.values
        return [values[index] for index in CURVE_PARAMETERS]
