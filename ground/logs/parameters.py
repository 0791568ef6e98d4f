"""The parameters that a log tells of, over time."""

from bisect import bisect_right
from itertools import pairwise
from typing import NamedTuple

from ground.logs.reader import MessageLog
from protocol import dialect
from protocol.frame import Address


class LoggedChange(NamedTuple):
    """A parameter that took another value, `time_s` into the log."""

    time_s: float
    name: str
    before: float
    value: float


class _Told(NamedTuple):
    """A value, and how far into the log it was told."""

    time_s: float
    value: float


class LoggedParameters:
    """The values of `vehicle`'s parameters in `log`, as its PARAM_VALUEs told them.

    `names` are in the vehicle's own order. `complete`: the log has every one of them, so that the vehicle's own
    indices can be used.
    """

    def __init__(self, log: MessageLog, vehicle: Address) -> None:
        self.total = 0
        self._told: dict[str, list[_Told]] = {}
        places: dict[str, int] = {}
        for entry in log.of(vehicle):
            message = entry.message
            if not isinstance(message, dialect.MAVLink_param_value_message):
                continue
            self._told.setdefault(message.param_id, []).append(_Told(entry.time_s, message.param_value))
            if message.param_index < message.param_count:  # an answer to PARAM_SET may come without its place
                places[message.param_id] = message.param_index
                self.total = message.param_count
        self.names = sorted(self._told, key=lambda name: (places.get(name, len(places)), name))
        self.complete = self.total > 0 and sorted(places.values()) == list(range(self.total))

    def value(self, name: str, time_s: float) -> float:
        """What `name` was at `time_s`: the last told by then, or the first told at all. Raises KeyError."""
        told = self._told[name]
        return told[max(bisect_right(told, time_s, key=lambda value: value.time_s) - 1, 0)].value

    def values(self, time_s: float) -> dict[str, float]:
        """All of them at `time_s`."""
        return {name: self.value(name, time_s) for name in self.names}

    def changes(self) -> list[LoggedChange]:
        """Every change of a value, in the order in which they came."""
        found = [LoggedChange(later.time_s, name, earlier.value, later.value) for name, told in self._told.items()
                 for earlier, later in pairwise(told) if later.value != earlier.value]
        return sorted(found)
