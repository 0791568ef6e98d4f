"""Where received messages wait for the control loop: the newest sample, the lockstep tick, and bounded queues."""

from .generated_messages import (
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
    PARAM_SET,
)
from .ticks import ticks_diff

_QUESTIONS = 64
_ORDERS = 32
_URGENT = 8
_FILES = 4  # each holds a quarter of a kilobyte
_RESERVED = 4  # last places of a queue, for senders that have nothing in it
_ORDER_MESSAGES = (COMMAND_LONG, COMMAND_INT, PARAM_SET, MANUAL_CONTROL, HEARTBEAT)


class Queue:
    """Requests (message, values, system, component), oldest first; one sender alone cannot fill it."""

    def __init__(self, room):
        self.requests = []
        self._room = room
        self._waiting = {}  # how many, by sender

    def put(self, request):
        """Add a request; False if there is no room for it."""
        count = len(self.requests)
        sender = request[2] << 8 | request[3]
        waiting = self._waiting.get(sender, 0)
        if count >= self._room or (waiting and count >= self._room - _RESERVED):
            return False
        self._waiting[sender] = waiting + 1
        self.requests.append(request)
        return True

    def take(self):
        """The oldest request."""
        request = self.requests.pop(0)
        sender = request[2] << 8 | request[3]
        left = self._waiting[sender] - 1
        if left:
            self._waiting[sender] = left
        else:
            del self._waiting[sender]
        return request


class Inbox:
    """Samples and ticks go past the queues, so that no flood of requests can hold them up.

    What changes something (`orders`) does not wait behind what only asks (`questions`); disarming, and PARK, wait for
    nobody: `urgent` holds them with the number of orders that came before.
    """

    def __init__(self):
        self.sample = None  # values of KITE_SENSORS, the newest since the last tick
        self.tick = None  # values of KITE_TICK
        self.questions = Queue(_QUESTIONS)
        self.orders = Queue(_ORDERS)
        self.urgent = []
        self.files = []  # FILE_TRANSFER_PROTOCOL: (values, system, component)
        self.refused = 0  # requests that found their queue full

    def put(self, message, values, system, component, sequence=None):
        """Take a message (values in wire order) from `system` and `component`, with its frame's sequence number."""
        if message == KITE_SENSORS:
            if self.sample is None or ticks_diff(values[0], self.sample[0]) > 0:
                self.sample = values
        elif message == KITE_TICK:
            self.tick = values
        elif not self._put_request(message, values, system, component):
            self.refused += 1

    def take_sample(self):
        """The newest sample since the last call, or None."""
        sample = self.sample
        self.sample = None
        return sample

    def _put_request(self, message, values, system, component):
        if message == FILE_TRANSFER_PROTOCOL:
            if len(self.files) >= _FILES:
                return False
            self.files.append((values, system, component))
            return True
        request = (message, values, system, component)
        if message not in _ORDER_MESSAGES:
            return self.questions.put(request)
        if message in (COMMAND_LONG, COMMAND_INT) and is_safe(values) and len(self.urgent) < _URGENT:
            self.urgent.append((request, len(self.orders.requests)))
            return True
        return self.orders.put(request)


def is_safe(values):
    """True for a command (values of COMMAND_LONG or COMMAND_INT) that brings the kite to rest: disarm, or PARK."""
    if values[7] == MAV_CMD_COMPONENT_ARM_DISARM:
        return values[0] == 0.0
    return values[7] == MAV_CMD_DO_SET_MODE and values[1] in (KITE_MODE_PARK, KITE_MODE_STANDBY)
