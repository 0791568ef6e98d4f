"""Received messages that wait for the control loop: the newest sample, the lockstep tick, and bounded queues."""

from ..clock import ticks_diff
from ..mavlink.generated_messages import (
    COMMAND_INT,
    COMMAND_LONG,
    FILE_TRANSFER_PROTOCOL,
    HEARTBEAT,
    KITE_MODE_PARK,
    KITE_MODE_STANDBY,
    KITE_SENSORS,
    KITE_TICK,
    MANUAL_CONTROL,
    MAV_CMD_COMPONENT_ARM_DISARM,
    MAV_CMD_DO_SET_MODE,
    MAV_CMD_PREFLIGHT_STORAGE,
    MAV_CMD_SET_MESSAGE_INTERVAL,
    MISSION_REQUEST_LIST,
    PARAM_REQUEST_LIST,
    PARAM_REQUEST_READ,
    PARAM_SET,
    PING,
    RADIO_STATUS,
    TIMESYNC,
)

_QUESTIONS = 64
_ORDERS = 32
_URGENT = 4  # of each kind
_FILES = 4  # each holds a quarter of a kilobyte
_RESERVED = 4  # last places of a queue, for senders that have nothing in it
_ORDER_MESSAGES = (COMMAND_LONG, COMMAND_INT, PARAM_SET, MANUAL_CONTROL, HEARTBEAT, RADIO_STATUS)
_QUESTION_MESSAGES = (PARAM_REQUEST_LIST, PARAM_REQUEST_READ, MISSION_REQUEST_LIST, TIMESYNC, PING)
_COMMANDS = (COMMAND_LONG, COMMAND_INT)
# Commands that change something; the others only ask, and wait until the link has room for an answer.
ORDERED = (
    MAV_CMD_COMPONENT_ARM_DISARM, MAV_CMD_DO_SET_MODE, MAV_CMD_PREFLIGHT_STORAGE, MAV_CMD_SET_MESSAGE_INTERVAL,
)


class Queue:
    """Requests (message, values, system, component, sequence), oldest first; one sender alone cannot fill it."""

    def __init__(self, room):
        self.requests = []
        self._room = room
        self._waiting = {}  # how many, by sender
        self._last = -1  # sender of the one that was taken fairly last

    def put(self, request, position=None):
        """Add a request, behind all others where no `position` is given; False if there is no room for it."""
        count = len(self.requests)
        sender = sender_of(request)
        waiting = self._waiting.get(sender, 0)
        if count >= self._room or (waiting and count >= self._room - _RESERVED):
            return False
        self._waiting[sender] = waiting + 1
        self.requests.insert(count if position is None else position, request)
        return True

    def take_fairly(self):
        """The oldest request of another sender than the last one's, if there is any."""
        request = self.take(first_of_another(self.requests, self._last))
        self._last = sender_of(request)
        return request

    def take(self, index=0):
        """The oldest request, or the one at `index`."""
        request = self.requests.pop(index)
        sender = sender_of(request)
        left = self._waiting[sender] - 1
        if left:
            self._waiting[sender] = left
        else:
            del self._waiting[sender]
        return request


class Inbox:
    """Samples and ticks bypass the queues, so that no flood of requests can delay them.

    Requests that change something (`orders`) do not wait behind those that only read (`questions`). Disarm and PARK
    wait for nothing: `urgent` holds them with the number of orders that came before. Each of the two has its own places
    there, and when these are full, a new one replaces the last: all of a kind do the same.
    """

    def __init__(self):
        self.sample = None  # values of KITE_SENSORS, the newest since the last tick
        self.tick = None  # values of KITE_TICK
        self.questions = Queue(_QUESTIONS)
        self.orders = Queue(_ORDERS)
        self.urgent = []  # (request, orders that came before)
        self.files = []  # FILE_TRANSFER_PROTOCOL: (values, system, component)
        self.refused = 0  # requests that found their queue full

    def put(self, message, values, system, component, sequence=None):
        """Take a message (values in wire order) from `system` and `component`; `sequence` is its frame's number."""
        if message == KITE_SENSORS:
            if self.sample is None or ticks_diff(values[0], self.sample[0]) > 0:
                self.sample = values
        elif message == KITE_TICK:
            self.tick = values
        elif not self._put_request(message, values, system, component, sequence):
            self.refused += 1

    def take_sample(self):
        """The newest sample since the last call, or None."""
        sample = self.sample
        self.sample = None
        return sample

    def take_urgent(self):
        """What is urgent since the last call, oldest first: (request, orders that came before it)."""
        urgent = self.urgent
        if urgent:
            self.urgent = []
        return urgent

    def _put_request(self, message, values, system, component, sequence):
        if message == FILE_TRANSFER_PROTOCOL:
            if len(self.files) >= _FILES:
                return False
            self.files.append((values, system, component))
            return True
        request = (message, values, system, component, sequence)
        if message in _QUESTION_MESSAGES or (message in _COMMANDS and values[7] not in ORDERED):
            return self.questions.put(request)
        if message not in _ORDER_MESSAGES:
            return True  # nobody here has a use for it
        if message in _COMMANDS and is_safe(values):
            return self._put_urgent(request)
        return self.orders.put(request)

    def _put_urgent(self, request):
        """False where one of the same kind had to give way."""
        kind = disarms(request[1])
        same = [index for index in range(len(self.urgent)) if disarms(self.urgent[index][0][1]) == kind]
        full = len(same) >= _URGENT
        if full:
            self.urgent.pop(same[-1])
        self.urgent.append((request, len(self.orders.requests)))
        return not full


def sender_of(request):
    """System and component of a request's sender, as one number."""
    _, _, system, component, _ = request
    return system << 8 | component


def first_of_another(requests, last):
    """Index of the oldest of `requests` that is not of the sender `last`; 0 where all are."""
    for index in range(len(requests)):
        if sender_of(requests[index]) != last:
            return index
    return 0


def is_safe(values):
    """True for a command (values of COMMAND_LONG or COMMAND_INT) that brings the kite to rest: disarm, or PARK."""
    return disarms(values) or (values[7] == MAV_CMD_DO_SET_MODE and values[1] == KITE_MODE_PARK)


def disarms(values):
    """True for a command that disarms, or asks for STANDBY."""
    if values[7] == MAV_CMD_COMPONENT_ARM_DISARM:
        return values[0] == 0.0
    return values[7] == MAV_CMD_DO_SET_MODE and values[1] == KITE_MODE_STANDBY
