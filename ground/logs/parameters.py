"""The parameters in a log, over time."""

from bisect import bisect_right
from itertools import pairwise
from typing import NamedTuple

from ground.logs.reader import MessageLog
from protocol import dialect
from protocol.frame import Address


class LoggedChange(NamedTuple):
    """A parameter's change of value, `time_s` [s] into the log."""

    time_s: float
    name: str
    before: float
    value: float


class _Reported(NamedTuple):
    """A reported value, and its time in the log [s]."""

    time_s: float
    value: float


class LoggedParameters:
    """The values of `vehicle`'s parameters in `log`, from its PARAM_VALUEs.

    `names` are in the vehicle's order. `complete`: the log has all of them, so that the vehicle's indices can be used.
    """

    def __init__(self, log: MessageLog, vehicle: Address) -> None:
        self.total = 0
        self._reported: dict[str, list[_Reported]] = {}
        places: dict[str, int] = {}
        for entry in log.of(vehicle):
            message = entry.message
            if not isinstance(message, dialect.MAVLink_param_value_message):
                continue
            self._reported.setdefault(message.param_id, []).append(_Reported(entry.time_s, message.param_value))
            if message.param_index < message.param_count:  # the answer to a PARAM_SET may lack the index
                places[message.param_id] = message.param_index
                self.total = message.param_count
        self.names = sorted(self._reported, key=lambda name: (places.get(name, len(places)), name))
        self.complete = self.total > 0 and sorted(places.values()) == list(range(self.total))

    def value(self, name: str, time_s: float) -> float:
        """The value of `name` at `time_s` [s]: the last one by then, else the first one after. Raises KeyError."""
        reported = self._reported[name]
        return reported[max(bisect_right(reported, time_s, key=lambda value: value.time_s) - 1, 0)].value

    def values(self, time_s: float) -> dict[str, float]:
        """All values at `time_s` [s]."""
        return {name: self.value(name, time_s) for name in self.names}

    def changes(self) -> list[LoggedChange]:
        """Every change of a value, in order of time."""
        found = [LoggedChange(later.time_s, name, earlier.value, later.value)
                 for name, reported in self._reported.items()
                 for earlier, later in pairwise(reported) if later.value != earlier.value]
        return sorted(found)
