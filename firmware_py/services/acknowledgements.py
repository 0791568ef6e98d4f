"""Queue of command acknowledgements, sent as the link's budget allows."""

from ..mavlink.generated_messages import COMMAND_ACK
from .inbox import Queue

_ROOM = 16


class Acknowledgements:
    """Bounded, and fair between senders; what does not fit is counted in `dropped`, and its station retries."""

    def __init__(self, link):
        self._link = link
        self._queue = Queue(_ROOM)
        self.dropped = 0

    def put(self, command, result, system, component):
        """Acknowledge a command of `system` and `component`, at once if there is room."""
        values = (command, result, 0, 0, system, component)
        if not self._queue.put((COMMAND_ACK, values, system, component, None)):
            self.dropped += 1
        self.send_some()

    def send_some(self):
        """Send what waits, while there is room."""
        budget = self._link.budget
        while self._queue.requests and budget.has_acknowledgement_room():
            request = self._queue.take_fairly()
            budget.spend_on_acknowledgement(self._link.send(COMMAND_ACK, request[1]))
