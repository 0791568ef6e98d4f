"""Where received messages wait for the control loop: the newest sample, the lockstep tick, and a bounded queue."""

from .generated_messages import COMMAND_LONG, KITE_SENSORS, KITE_TICK, MAV_CMD_COMPONENT_ARM_DISARM
from .ticks import ticks_diff

_ROOM = 64


class Inbox:
    """Samples and ticks go past the queue, so that no flood of requests can hold them up."""

    def __init__(self):
        self.sample = None  # values of KITE_SENSORS, the newest since the last tick
        self.tick = None  # values of KITE_TICK
        self.requests = []  # (message, values, system, component), oldest first
        self.refused = 0  # requests that found the queue full

    def put(self, message, values, system, component):
        """Take a message (values in wire order) from `system` and `component`."""
        if message == KITE_SENSORS:
            if self.sample is None or ticks_diff(values[0], self.sample[0]) > 0:
                self.sample = values
        elif message == KITE_TICK:
            self.tick = values
        elif message == COMMAND_LONG and values[7] == MAV_CMD_COMPONENT_ARM_DISARM and values[0] == 0.0:
            if len(self.requests) >= _ROOM:
                self.requests.pop()
                self.refused += 1
            self.requests.insert(0, (message, values, system, component))  # a disarm waits for nobody
        elif len(self.requests) < _ROOM:
            self.requests.append((message, values, system, component))
        else:
            self.refused += 1

    def take_sample(self):
        """The newest sample since the last call, or None."""
        sample = self.sample
        self.sample = None
        return sample
