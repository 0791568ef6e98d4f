"""Received messages that wait for the control loop: the newest sample, the lockstep tick, and bounded queues."""

from ..clock import ticks_diff
from ..mavlink.generated_messages import (
    COMMAND_INT,
    COMMAND_LONG,
    FILE_TRANSFER_PROTOCOL,
    HEARTBEAT,
    KITE_SENSORS,
    KITE_TICK,
    MANUAL_CONTROL,
    MISSION_REQUEST_LIST,
    PARAM_REQUEST_LIST,
    PARAM_REQUEST_READ,
    PARAM_SET,
    PING,
    RADIO_STATUS,
    TIMESYNC,
)
from .request import Command, ParameterSet, Request

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Any, Final

    from ..sample import Sample

_QUESTIONS = 64  # type: Final
_ORDERS = 32  # type: Final
_URGENT = 4  # type: Final  # of each kind
_FILES = 4  # type: Final  # each holds a quarter of a kilobyte
_RESERVED = 4  # type: Final  # last places of a queue, for senders that have nothing in it
_ORDER_MESSAGES = (PARAM_SET, MANUAL_CONTROL, HEARTBEAT, RADIO_STATUS)  # type: Final[tuple[int, ...]]
_QUESTION_MESSAGES = (
    PARAM_REQUEST_LIST, PARAM_REQUEST_READ, MISSION_REQUEST_LIST, TIMESYNC, PING,
)  # type: Final[tuple[int, ...]]
_COMMANDS = (COMMAND_LONG, COMMAND_INT)  # type: Final[tuple[int, ...]]


class Queue:
    """Requests (request.py), oldest first; one sender alone cannot fill it."""

    def __init__(self, room: int) -> None:
        self.requests: "list[Request]" = []
        self._room = room
        self._waiting: dict[int, int] = {}  # how many, by sender
        self._last: int = -1  # sender of the one that was taken fairly last

    def put(self, request: "Request", position: int | None = None) -> bool:
        """Add a request, behind all others where no `position` is given; False if there is no room for it."""
        count = len(self.requests)
        sender = request.sender
        waiting = self._waiting.get(sender, 0)
        if count >= self._room or (waiting and count >= self._room - _RESERVED):
            return False
        self._waiting[sender] = waiting + 1
        self.requests.insert(count if position is None else position, request)
        return True

    def take_fairly(self) -> "Request":
        """The oldest request of another sender than the last one's, if there is any."""
        request = self.take(first_of_another(self.requests, self._last))
        self._last = request.sender
        return request

    def take(self, index: int = 0) -> "Request":
        """The oldest request, or the one at `index`."""
        request = self.requests.pop(index)
        sender = request.sender
        left = self._waiting[sender] - 1
        if left:
            self._waiting[sender] = left
        else:
            del self._waiting[sender]
        return request


class Urgent:
    """A `command` that waits for nobody, with how many orders came `before` it."""

    def __init__(self, command: "Command", before: int) -> None:
        self.command = command
        self.before = before


class Inbox:
    """Samples and ticks bypass the queues, so that no flood of requests can delay them.

    Requests that change something (`orders`) do not wait behind those that only read (`questions`). Disarm and PARK
    wait for nothing: `urgent` holds them with the number of orders that came before. Each of the two has its own places
    there, and when these are full, a new one replaces the last: all of a kind do the same.
    """

    def __init__(self) -> None:
        self.sample: "Sample | None" = None  # values of KITE_SENSORS, the newest since the last tick
        self.tick: tuple[int, int] | None = None  # values of KITE_TICK
        self.questions = Queue(_QUESTIONS)
        self.orders = Queue(_ORDERS)
        self.urgent: "list[Urgent]" = []
        self.files: "list[tuple[tuple[Any, ...], int, int]]" = []  # FILE_TRANSFER_PROTOCOL: (values, system, component)
        self.refused: int = 0  # requests that found their queue full

    def put(
        self, message: int, values: "tuple[Any, ...]", system: int, component: int, sequence: int | None = None
    ) -> None:
        """Take a message (values in wire order) from `system` and `component`; `sequence` is its frame's number."""
        if message == KITE_SENSORS:
            newest = self.sample
            if newest is None or ticks_diff(_stamp(values), _stamp(newest)) > 0:
                self.sample = values
        elif message == KITE_TICK:
            self.tick = values
        elif not self._put_request(message, values, system, component, sequence):
            self.refused += 1

    def take_sample(self) -> "Sample | None":
        """The newest sample since the last call, or None."""
        sample = self.sample
        self.sample = None
        return sample

    def take_urgent(self) -> "list[Urgent]":
        """What is urgent since the last call, oldest first: `command`, and how many orders came `before` it."""
        urgent = self.urgent
        if urgent:
            self.urgent = []
        return urgent

    def _put_request(
        self, message: int, values: "tuple[Any, ...]", system: int, component: int, sequence: int | None
    ) -> bool:
        if message == FILE_TRANSFER_PROTOCOL:
            if len(self.files) >= _FILES:
                return False
            self.files.append((values, system, component))
            return True
        if message in _COMMANDS:
            command = Command(message, values, system, component, sequence)
            if not command.changes():
                return self.questions.put(command)
            return self._put_urgent(command) if command.is_urgent() else self.orders.put(command)
        kind = ParameterSet if message == PARAM_SET else Request
        request = kind(message, values, system, component, sequence)
        if message in _QUESTION_MESSAGES:
            return self.questions.put(request)
        return message not in _ORDER_MESSAGES or self.orders.put(request)  # nobody here has a use for the others

    def _put_urgent(self, command: "Command") -> bool:
        """False where one of the same kind had to give way."""
        kind = command.disarms()
        same = [entry for entry in self.urgent if entry.command.disarms() == kind]
        full = len(same) >= _URGENT
        if full:
            self.urgent.remove(same[-1])
        self.urgent.append(Urgent(command, len(self.orders.requests)))
        return not full


def first_of_another(requests: "Sequence[Request]", last: int) -> int:
    """Index of the oldest of `requests` that is not of the sender `last`; 0 where all are."""
    for index in range(len(requests)):
        if requests[index].sender != last:
            return index
    return 0


def _stamp(sample: "Sample") -> int:
    """The time stamp of values of KITE_SENSORS [us]."""
    time_us, _, _, _, _, _, _, _, _, _ = sample
    return time_us
