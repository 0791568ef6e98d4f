"""The whole list of parameters, as it comes in and with the holes that are left in it."""

from collections.abc import Callable

from ground.link.framing import Message
from protocol import dialect

Progress = Callable[[int, int], None]


class Listing:
    """The parameters that have come so far: (name, value) by index. `progress(n, total)` is told as they come."""

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

    def missing(self, names: list[str]) -> str:
        """What has not come, in words; `names` is the order that the vehicle's list is thought to have."""
        if self.total is None:
            return "parameter list (nothing received)"
        holes = self.holes()
        first = names[holes[0]] if self.total == len(names) else f"parameter number {holes[0]}"
        return f"{first} and {len(holes) - 1} more of {self.total}" if len(holes) > 1 else first

    def observe(self, time_s: float, message: Message, frame: bytes) -> None:
        """Take in a PARAM_VALUE; one without an index of its own (65535) tells nothing here."""
        if not isinstance(message, dialect.MAVLink_param_value_message) or message.param_index >= message.param_count:
            return
        self.total = message.param_count
        self.values[message.param_index] = (message.param_id, message.param_value)
        if self._progress:
            self._progress(len(self.values), self.total)
