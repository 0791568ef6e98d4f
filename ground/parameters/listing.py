"""The parameter list as it arrives, and the gaps in it."""

from collections.abc import Callable

from ground.link.framing import Message
from protocol import dialect

Progress = Callable[[int, int], None]


class Listing:
    """The parameters received so far: (name, value) by index. `progress(n, total)` is called for each."""

    def __init__(self, progress: Progress | None) -> None:
        self.values: dict[int, tuple[str, float]] = {}
        self.total: int | None = None
        self._progress = progress

    @property
    def complete(self) -> bool:
        return self.total is not None and len(self.values) >= self.total

    def holes(self) -> list[int]:
        """Indices not yet received."""
        return [index for index in range(self.total or 0) if index not in self.values]

    def missing(self, names: list[str]) -> str:
        """What is missing, in words; `names` are in the presumed order of the vehicle's list."""
        if self.total is None:
            return "parameter list (nothing received)"
        holes = self.holes()
        first = names[holes[0]] if self.total == len(names) else f"parameter number {holes[0]}"
        return f"{first} and {len(holes) - 1} more of {self.total}" if len(holes) > 1 else first

    def observe(self, time_s: float, message: Message, frame: bytes) -> None:
        """Add a PARAM_VALUE; one without an index (65535) is ignored."""
        if not isinstance(message, dialect.MAVLink_param_value_message) or message.param_index >= message.param_count:
            return
        self.total = message.param_count
        self.values[message.param_index] = (message.param_id, message.param_value)
        if self._progress:
            self._progress(len(self.values), self.total)
