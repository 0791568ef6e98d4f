"""Reads and writes the vehicle's parameters over a link with loss and delay.

Every request is repeated until it is answered. With a loss of 20 % each way, an exchange succeeds with probability
0.64; ATTEMPTS in a row fail once in 1e9.
"""

from collections.abc import Callable, Sequence

from ground.errors import NoAnswerError, VehicleError
from ground.link.connection import SILENCE_S, Connection
from ground.link.framing import Message
from ground.parameters.changes import Change, ChangeState, Table, Told, count_states, explain, refuses
from ground.parameters.listing import Listing, Progress
from ground.parameters.writer import ParameterWriter
from protocol import dialect
from protocol.parameter_table import load_parameters
from protocol.single_precision import float32

ATTEMPTS = 20
HOLES_AT_ONCE = 10


class ParameterClient:
    """The vehicle's parameters, by name. `table` explains refusals; the vehicle alone decides.

    `retries` counts the repeated requests since the start.
    """

    def __init__(self, connection: Connection, table: Table | None = None) -> None:
        self.table = load_parameters() if table is None else table
        self.retries = 0
        self.connection = connection

    def fetch(self, name: str) -> float:
        """The vehicle's present value of `name`, in the table's unit.

        Raises:
            VehicleError: the vehicle has no such parameter, or did not answer.
        """
        def settled(message: Message) -> bool:
            if isinstance(message, dialect.MAVLink_param_error_message):
                return refuses(message, name) and message.error == dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST
            return isinstance(message, dialect.MAVLink_param_value_message) and message.param_id == name

        answer = self._ask(name, settled)
        if isinstance(answer, dialect.MAVLink_param_value_message):
            return answer.param_value
        raise VehicleError(explain(self.table, name, 0.0, dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST))

    def set(self, name: str, value: float) -> float:
        """Write `value`, rounded to float32, and return it as acknowledged.

        Raises:
            VehicleError: the vehicle refused, kept another value, or did not answer.
        """
        change = Change(name, None, float32(value))
        self.write([change])
        if change.state is ChangeState.REFUSED:
            raise VehicleError(change.reason)
        return change.wanted

    def write(self, changes: Sequence[Change], told: Told = lambda change: None) -> None:
        """Send `changes`, several at a time, and update the state of each.

        `told` is called with a change when the vehicle has answered it; a refused one may be accepted on a retry.
        Refusals raise nothing.

        Raises:
            NoAnswerError: some were not answered, so that it is unknown whether the vehicle has applied them.
        """
        started_s = self.connection.clock()
        writer = ParameterWriter(self.connection, self.table, ATTEMPTS)
        try:
            writer.write(changes, told)
        finally:
            self.retries += writer.retries
        open_ends = [change for change in changes if change.state in (ChangeState.EDITED, ChangeState.SENT)]
        if open_ends:
            which = f"{open_ends[0].name}: " if len(changes) == 1 else f"{count_states(changes)}: "
            raise NoAnswerError(which + self.connection.why_silent(started_s))

    def fetch_all(self, progress: Progress | None = None) -> dict[str, float]:
        """Every parameter of the vehicle, in its own order; `progress(n, total)` is called as they arrive.

        Raises:
            NoAnswerError: some never arrived; the message names the first of them.
        """
        listing = Listing(progress)
        self.connection.add_observer(listing.observe)
        try:
            started_s, fruitless, rounds = self.connection.clock(), 0, 0
            while not listing.complete and fruitless < ATTEMPTS and not self._is_down(started_s):
                before = len(listing.values)
                requests = self._requests(listing)
                for request in requests:
                    self.connection.send(request)
                self.retries += len(requests) if rounds else 0
                rounds += 1
                self._collect(listing, self.connection.patience_s(fruitless))
                fruitless = 0 if len(listing.values) > before else fruitless + 1
        finally:
            self.connection.remove_observer(listing.observe)
        if not listing.complete:
            raise NoAnswerError(f"{listing.missing(list(self.table))}: {self.connection.why_silent(started_s)}")
        return dict(listing.values[index] for index in sorted(listing.values))

    def _ask(self, name: str, settled: Callable[[Message], bool]) -> Message:
        """Request `name` until an answer is `settled`. Raises NoAnswerError if none arrives."""
        started_s = self.connection.clock()
        for attempt in range(ATTEMPTS):
            system, component = self.connection.target
            self.connection.send(
                dialect.MAVLink_param_request_read_message(system, component, name.encode("ascii"), -1))
            self.retries += attempt > 0
            answer = self.connection.wait_for(settled, self.connection.patience_s(attempt))
            if answer is not None:
                return answer
            if self._is_down(started_s):
                break
        raise NoAnswerError(f"{name}: {self.connection.why_silent(started_s)}")

    def _requests(self, listing: Listing) -> list[Message]:
        system, component = self.connection.target
        if listing.total is None:
            return [dialect.MAVLink_param_request_list_message(system, component)]
        return [dialect.MAVLink_param_request_read_message(system, component, b"", index)
                for index in listing.holes()[:HOLES_AT_ONCE]]

    def _collect(self, listing: Listing, patience_s: float) -> None:
        """Wait until the list is complete, or nothing has arrived for `patience_s` [s]."""
        count = -1
        while not listing.complete and count != len(listing.values):
            count = len(listing.values)
            self.connection.wait_until(lambda: len(listing.values) > count, patience_s)  # noqa: B023  (called here)

    def _is_down(self, since_s: float) -> bool:
        return self.connection.silence_s(since_s) >= SILENCE_S
