"""The parameter protocol: lists within the link's budget, reads by name or index, sets."""

from ..control.figure_eight import CURVE_PARAMETERS
from ..generated_enums import (
    KITE_MODE_TRACK,
    MAV_PARAM_ERROR_DOES_NOT_EXIST,
    MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
    MAV_PARAM_TYPE_REAL32,
    MAV_SEVERITY_WARNING,
)
from ..mavlink.generated_messages import PARAM_ERROR, PARAM_VALUE
from ..parameters.generated_parameters import COUNT, NAMES
from ..parameters.values import UNKNOWN

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Final

    from ..mavlink.interface import Link
    from ..modes.mode_machine import ModeMachine
    from ..parameters.values import Parameters
    from .request import ParameterSet

_PER_TICK = 2  # type: Final  # of those that nobody waits for one by one
_CHANGED_PER_TICK = 6  # type: Final
_REFUSALS = 8  # type: Final  # that wait for room on the link


class ParameterRequests:
    """Answers are broadcast, as MAVLink specifies: a station that requests the list joins one in progress."""

    def __init__(
        self, parameters: "Parameters", modes: "ModeMachine", link: "Link", say: "Callable[[int, str], None]"
    ) -> None:
        self._parameters = parameters
        self._modes = modes
        self._link = link
        self._say = say
        self._refusals: list[tuple[int, int, int, bytes, int]] = []  # values of PARAM_ERROR
        self._unsent: list[int] = []  # indices of parameters that have changed, or were refused a change
        self._next: int = 0  # of the list
        self._left: int = 0

    def list_all(self) -> None:
        """Send all parameters, from where a list has come to, once round."""
        if not self._left:
            self._next = 0
        self._left = COUNT

    def announce(self, index: int) -> None:
        """Send the value of a parameter when there is room."""
        if index not in self._unsent:
            self._unsent.append(index)

    def is_busy(self) -> bool:
        """True while something waits to be sent."""
        return self._left > 0 or bool(self._refusals or self._unsent)

    def answer_sets(self) -> None:
        """Answer what was set or refused, a few a tick, while the link has room for answers."""
        budget = self._link.budget
        while self._refusals and budget.claim_answer_room():
            self._link.answer(PARAM_ERROR, self._refusals.pop(0))
        for _ in range(_CHANGED_PER_TICK):
            if not self._unsent or not budget.claim_answer_room():
                return
            self._send(self._unsent.pop(0))

    def list_some(self) -> None:
        """Go on with a list, a few a tick, while the link has room for answers."""
        for _ in range(_PER_TICK):
            if not self._left or not self._link.budget.claim_answer_room():
                return
            self._left -= 1
            self._send(self._next)
            self._next = (self._next + 1) % COUNT

    def read(self, index: int, name: bytes, system: int, component: int) -> None:
        """Send a parameter by its index, or by its name where the index is negative."""
        wanted = self._parameters.index_of(name) if index < 0 else index
        if 0 <= wanted < COUNT:
            self._send(wanted)
        else:
            self._link.answer(PARAM_ERROR, (index, system, component, name, MAV_PARAM_ERROR_DOES_NOT_EXIST))

    def changes_curve(self, name: bytes, value: float) -> int:
        """Index of the parameter if setting it changes the target curve in flight, so that it must be checked first."""
        index = self._parameters.index_of(name)
        if index not in CURVE_PARAMETERS or self._modes.mode != KITE_MODE_TRACK:
            return UNKNOWN
        if self._parameters.values[index] == value or self._parameters.refusal(index, value, True):
            return UNKNOWN
        return index

    def set(self, request: "ParameterSet", problem: str | None) -> None:
        """Set a parameter as the `request`, a ParameterSet, asks, or refuse it.

        `problem` is what speaks against the curve that it makes, or None.
        """
        parameters = self._parameters
        index = parameters.index_of(request.name)
        error = parameters.refusal(index, request.value, self._modes.armed())
        if not error and problem is not None:
            error = MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE
            self._say(MAV_SEVERITY_WARNING, problem)
        if error:
            self._refuse(request, error)
        else:
            parameters.set(index, request.value)
        if index != UNKNOWN:
            self.announce(index)

    def _send(self, index: int) -> None:
        parameters = self._parameters
        values = (parameters.values[index], COUNT, index, NAMES[index], MAV_PARAM_TYPE_REAL32)
        self._link.answer(PARAM_VALUE, values)

    def _refuse(self, request: "ParameterSet", error: int) -> None:
        """Send PARAM_ERROR when there is room; what finds no place is forgotten: its station asks again."""
        if len(self._refusals) < _REFUSALS:
            self._refusals.append((-1, request.system, request.component, request.name, error))
