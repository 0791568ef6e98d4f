"""A parameter change on its way to the vehicle: edited, sent, acknowledged or refused."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum

from ground.link.connection import GROUND_SYSTEM, Connection
from ground.link.framing import Message
from protocol import dialect
from protocol.parameter_table import Parameter

RENAMING = "SYSTEM_ID"
_SURPRISES = 3  # unforeseen refusals before they are believed: one may answer an older request


class ChangeState(Enum):
    """Progress of a change. SENT: it is unknown whether the vehicle has applied it."""

    EDITED = "edited, not sent"
    SENT = "sent, not acknowledged"
    ACKNOWLEDGED = "acknowledged by the kite"
    REFUSED = "refused by the kite"


@dataclass
class Change:
    """Set `name` to `wanted`, a float32; `before` is the old value if known.

    `reason` says in one line why it was refused; `sent` counts the requests.
    """

    name: str
    before: float | None
    wanted: float
    state: ChangeState = ChangeState.EDITED
    reason: str = ""
    sent: int = 0


Told = Callable[[Change], None]
Table = dict[str, Parameter]


def count_states(changes: Sequence[Change]) -> str:
    """The number of `changes` in each state, in words."""
    counts = [(state, [change.state for change in changes].count(state)) for state in ChangeState]
    return ", ".join(f"{count} {state.value}" for state, count in counts if count)


class Setting:
    """Sends one change over `connection`, on each `send`, and evaluates the answers.

    `alone`: no other change is under way, so that a warning from the vehicle can be taken as the reason of a refusal.
    """

    def __init__(self, connection: Connection, table: Table, change: Change, alone: bool) -> None:
        self.change = change
        self.settled = False
        self.due_s = float("-inf")  # when to send it next
        self._connection, self._table, self._alone = connection, table, alone
        self._present: float | None = None
        self._error: int | None = None
        self._text: str | None = None
        self._refusals = 0

    @property
    def surprising(self) -> bool:
        """Whether it was refused for a reason not in the table: another parameter's value may be the cause."""
        return self._error is not None and not self._foreseen()

    def send(self) -> None:
        """Send it, or send it again."""
        system, component = self._connection.target
        change = self.change
        self._connection.send(dialect.MAVLink_param_set_message(
            system, component, change.name.encode("ascii"), change.wanted, dialect.MAV_PARAM_TYPE_REAL32))
        if change.name == RENAMING:
            self._connection.expect_renamed(int(change.wanted))
        self.due_s = self._connection.clock() + self._connection.patience_s(change.sent)
        change.sent += 1
        change.state = ChangeState.SENT

    def observe(self, message: Message) -> None:
        """Evaluate a message from the vehicle."""
        name = self.change.name
        if isinstance(message, dialect.MAVLink_statustext_message):
            if self._alone and message.severity <= dialect.MAV_SEVERITY_WARNING:
                self._text = message.text
        elif isinstance(message, dialect.MAVLink_param_value_message) and message.param_id == name:
            self._present = message.param_value
            if self._present == self.change.wanted:
                self.settled, self.change.state = True, ChangeState.ACKNOWLEDGED
        elif isinstance(message, dialect.MAVLink_param_error_message) and refuses(message, name):
            self._error = message.error
            self._refusals += 1
            if self._foreseen() or not self._alone or self._refusals >= _SURPRISES:
                self.settled = True
                self.give_up()

    def give_up(self) -> None:
        """Stop sending: what was received, if anything, is the answer."""
        change = self.change
        if self._error is not None:
            change.reason = explain(self._table, change.name, change.wanted, self._error, self._text)
        elif self._present is not None:
            change.reason = (f"{change.name}: set to {change.wanted:g}, but the kite keeps answering "
                             f"{self._present:g}")
        else:
            return
        change.state = ChangeState.REFUSED
        if change.name == RENAMING:
            self._connection.expect_renamed(None)

    def _foreseen(self) -> bool:
        return self._error is not None and foreseen(self._table, self.change.name, self.change.wanted, self._error)


def refuses(error: dialect.MAVLink_param_error_message, name: str) -> bool:
    """Whether this refusal concerns `name`, and is addressed to this ground station or to all."""
    return error.param_id == name and error.target_system in (0, GROUND_SYSTEM)


def foreseen(table: Table, name: str, value: float, error: int) -> bool:
    """Whether the table explains why setting `name` to `value` is refused with this MAV_PARAM_ERROR."""
    parameter = table.get(name)
    if parameter is None:
        return error == dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST
    if error == dialect.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE:
        return parameter.problem_with(value) is not None
    if error == dialect.MAV_PARAM_ERROR_READ_ONLY:
        return parameter.read_only
    return error == dialect.MAV_PARAM_ERROR_PERMISSION_DENIED and parameter.disarmed_only


def explain(table: Table, name: str, value: float, error: int, text: str | None = None) -> str:
    """One line on why the vehicle answered the setting of `name` to `value` with this MAV_PARAM_ERROR.

    `text` is a warning that the vehicle sent with it: it names a limit that is not in the table.
    """
    if error == dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST:
        return f"{name}: the kite has no such parameter"
    if error == dialect.MAV_PARAM_ERROR_READ_ONLY:
        return f"{name}: refused by the kite: it is read-only"
    if error == dialect.MAV_PARAM_ERROR_PERMISSION_DENIED:
        return f"{name}: refused by the kite: it can be set only while disarmed"
    if error == dialect.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE:
        problem = table[name].problem_with(value) if name in table else None
        reason = problem.removeprefix(f"{name} = ") if problem else text or f"it does not take the value {value:g}"
        return f"{name}: refused by the kite: {reason}"
    return f"{name}: refused by the kite with PARAM_ERROR {error}"
