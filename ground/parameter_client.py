"""Reads and writes the vehicle's parameters over a link that loses and delays.

Everything is asked again until it is answered. Where a fifth of the messages is lost each way, one exchange
succeeds with probability 0.64; ATTEMPTS of them all fail once in 1e9.
"""

from collections.abc import Callable

from ground.connection import GROUND_SYSTEM, Connection
from ground.errors import NoAnswerError, VehicleError
from ground.framing import Message
from ground.parameter_refusals import Table, explain, foreseen
from protocol import dialect
from protocol.parameter_table import float32, load_parameters

ATTEMPTS = 20
SILENCE_S = 10.0  # no message of any kind for so long: the link is down
HOLES_AT_ONCE = 10
_SURPRISES = 3  # refusals that the table does not foresee, before they are believed: one may answer an older request

Progress = Callable[[int, int], None]


class ParameterClient:
    """The vehicle's parameters, by name. `table` explains refusals; the vehicle alone decides."""

    def __init__(self, connection: Connection, table: Table | None = None) -> None:
        self.table = load_parameters() if table is None else table
        self._connection = connection

    def fetch(self, name: str) -> float:
        """The vehicle's present value of `name`, in the table's unit.

        Raises:
            VehicleError: the vehicle does not know it, or did not answer.
        """
        def settled(message: Message) -> bool:
            if isinstance(message, dialect.MAVLink_param_error_message):
                return _refuses(message, name) and message.error == dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST
            return isinstance(message, dialect.MAVLink_param_value_message) and message.param_id == name

        system, component = self._connection.target
        request = dialect.MAVLink_param_request_read_message(system, component, name.encode("ascii"), -1)
        answer = self._ask(name, request, settled)
        if isinstance(answer, dialect.MAVLink_param_value_message):
            return answer.param_value
        raise VehicleError(explain(self.table, name, 0.0, dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST))

    def set(self, name: str, value: float) -> float:
        """Write `value` (rounded to float32) and return what the vehicle acknowledged, which is the same.

        Raises:
            VehicleError: the vehicle refused, holds on to another value, or did not answer.
        """
        wanted = float32(value)
        setting = _Setting(self.table, name, wanted)
        system, component = self._connection.target
        request = dialect.MAVLink_param_set_message(
            system, component, name.encode("ascii"), wanted, dialect.MAV_PARAM_TYPE_REAL32)
        try:
            self._ask(name, request, setting.settled)
        except NoAnswerError:
            if setting.error is None and setting.present is None:
                raise
        if setting.present == wanted:
            return wanted
        if setting.error is not None:
            raise VehicleError(explain(self.table, name, wanted, setting.error, setting.text))
        raise VehicleError(f"{name}: asked for {wanted:g}, but the vehicle keeps answering {setting.present:g}")

    def fetch_all(self, progress: Progress | None = None) -> dict[str, float]:
        """Every parameter of the vehicle, in its own order; `progress(n, total)` is told as they come.

        Raises:
            NoAnswerError: some of them never came; names the first of those.
        """
        listing = _Listing(progress)
        self._connection.add_observer(listing.observe)
        try:
            started_s, fruitless = self._connection.clock(), 0
            while not listing.complete and fruitless < ATTEMPTS and not self._is_down(started_s):
                before = len(listing.values)
                for request in self._requests(listing):
                    self._connection.send(request)
                self._collect(listing)
                fruitless = 0 if len(listing.values) > before else fruitless + 1
        finally:
            self._connection.remove_observer(listing.observe)
        if not listing.complete:
            raise NoAnswerError(f"{self._whats_missing(listing)}: {self._no_answer(started_s)}")
        return dict(listing.values[index] for index in sorted(listing.values))

    def _ask(self, name: str, request: Message, settled: Callable[[Message], bool]) -> Message:
        """Send `request` until an answer is `settled`. Raises NoAnswerError when none comes."""
        started_s = self._connection.clock()
        for _ in range(ATTEMPTS):
            self._connection.send(request)
            answer = self._connection.wait_for(settled, self._connection.round_trip.timeout_s)
            if answer is not None:
                return answer
            if self._is_down(started_s):
                break
        raise NoAnswerError(f"{name}: {self._no_answer(started_s)}")

    def _requests(self, listing: "_Listing") -> list[Message]:
        system, component = self._connection.target
        if listing.total is None:
            return [dialect.MAVLink_param_request_list_message(system, component)]
        return [dialect.MAVLink_param_request_read_message(system, component, b"", index)
                for index in listing.holes()[:HOLES_AT_ONCE]]

    def _collect(self, listing: "_Listing") -> None:
        """Wait until all are there, or none came for as long as an answer may take."""
        count = -1
        while not listing.complete and count != len(listing.values):
            count = len(listing.values)
            self._connection.wait_until(
                lambda: len(listing.values) > count, self._connection.round_trip.timeout_s)  # noqa: B023  (called here)

    def _is_down(self, since_s: float) -> bool:
        return self._connection.silence_s(since_s) >= SILENCE_S

    def _no_answer(self, started_s: float) -> str:
        tried = f"no answer in {self._connection.clock() - started_s:.0f} s"
        if self._is_down(started_s):
            return f"{tried}, and nothing else from the vehicle: the link is down"
        return f"{tried}, though the vehicle is heard: what is sent does not reach it"

    def _whats_missing(self, listing: "_Listing") -> str:
        if listing.total is None:
            return "parameter list (none of it came)"
        names, holes = list(self.table), listing.holes()
        first = names[holes[0]] if listing.total == len(names) else f"parameter number {holes[0]}"
        return f"{first} and {len(holes) - 1} more of {listing.total}" if len(holes) > 1 else first


class _Setting:
    """What the vehicle says while one value is being set."""

    def __init__(self, table: Table, name: str, wanted: float) -> None:
        self.present: float | None = None
        self.error: int | None = None
        self.text: str | None = None  # a warning of the vehicle's, which may say why
        self._table, self._name, self._wanted = table, name, wanted
        self._refusals = 0

    def settled(self, message: Message) -> bool:
        """Whether `message` acknowledges the value, or refuses it for good."""
        if isinstance(message, dialect.MAVLink_statustext_message) and message.severity <= dialect.MAV_SEVERITY_WARNING:
            self.text = message.text
        if isinstance(message, dialect.MAVLink_param_value_message) and message.param_id == self._name:
            self.present = message.param_value
            return self.present == self._wanted
        if isinstance(message, dialect.MAVLink_param_error_message) and _refuses(message, self._name):
            self.error = message.error
            self._refusals += 1
            return self._refusals >= _SURPRISES or foreseen(self._table, self._name, self._wanted, self.error)
        return False


class _Listing:
    """The parameters that have come so far: (name, value) by index."""

    def __init__(self, progress: Progress | None) -> None:
        self.values: dict[int, tuple[str, float]] = {}
        self.total: int | None = None
        self._progress = progress

    @property
    def complete(self) -> bool:
        return self.total is not None and len(self.values) >= self.total

    def holes(self) -> list[int]:
        """Indices that have not come."""
        return [index for index in range(self.total or 0) if index not in self.values]

    def observe(self, time_s: float, message: Message, frame: bytes) -> None:
        """Take in a PARAM_VALUE; one without an index of its own (65535) tells nothing here."""
        if not isinstance(message, dialect.MAVLink_param_value_message) or message.param_index >= message.param_count:
            return
        self.total = message.param_count
        self.values[message.param_index] = (message.param_id, message.param_value)
        if self._progress:
            self._progress(len(self.values), self.total)


def _refuses(error: dialect.MAVLink_param_error_message, name: str) -> bool:
    """Whether this refusal is about `name`, and meant for this ground station or for all."""
    return error.param_id == name and error.target_system in (0, GROUND_SYSTEM)
