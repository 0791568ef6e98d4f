"""Every KITE_STATE that was heard, as numpy arrays."""

import threading
from array import array
from typing import TYPE_CHECKING

from ground.link.framing import Message
from protocol import dialect

if TYPE_CHECKING:
    import numpy as np

_STATE = dialect.MAVLink_kite_state_message
_WRAP_US = 1 << 30
COLUMNS = ("time_s", "heard_s", "sample_age_s", *_STATE.ordered_fieldnames)


class StateHistory:
    """The columns COLUMNS, a row for each KITE_STATE, oldest first; at most `most` rows, the latest.

    `time_s` is the vehicle's clock at the tick, counted from its first row on and without wraps; `heard_s` is the
    ground's clock when it came; `sample_age_s` is how old the newest sample was at that tick, if both clocks are one.
    The others are the message's fields in its units (SI and radians; `time_us` and the like in microseconds). When the
    vehicle is started anew, `time_s` goes on from its last row.

    One thread may observe while others read: an array of numbers that numpy is copying cannot grow.
    """

    def __init__(self, most: int = 200_000) -> None:
        self._rows = array("d")
        self._most = most
        self._time_us = 0
        self._lock = threading.Lock()

    def __len__(self) -> int:
        with self._lock:
            return len(self._rows) // len(COLUMNS)

    @property
    def newest_s(self) -> float | None:
        """`time_s` of the newest row, or None before the first."""
        with self._lock:
            return self._rows[-len(COLUMNS)] if self._rows else None

    def __getitem__(self, column: str) -> "np.ndarray":
        """One column, shape (n,)."""
        return self.arrays()[column]

    def arrays(self, seconds: float | None = None) -> "dict[str, np.ndarray]":
        """All columns by name, each of shape (n,): of the last `seconds` [s] of the vehicle's time, or of all.

        Raises:
            ValueError: `seconds` is not a positive time.
        """
        import numpy as np  # noqa: PLC0415  (slow to load, and the command line does without)

        if seconds is not None and not seconds > 0.0:
            raise ValueError(f"the last {seconds:g} s: must be more than 0")
        with self._lock:
            rows = np.array(self._rows).reshape(-1, len(COLUMNS))
        if seconds is not None and len(rows):
            rows = rows[rows[:, 0] > rows[-1, 0] - seconds]
        return {name: rows[:, index] for index, name in enumerate(COLUMNS)}

    def observe(self, time_s: float, message: Message, frame: bytes) -> None:
        """Take in one of the vehicle's messages, as an observer of a connection."""
        if not isinstance(message, _STATE):
            return
        with self._lock:
            self._add(time_s, message)

    def _add(self, time_s: float, message: _STATE) -> None:
        step_us = _difference(message.time_us, self._time_us) if self._rows else 0
        if step_us < 0 and step_us > -1_000_000:
            return  # was overtaken on the way
        before_s = self._rows[-len(COLUMNS)] if self._rows else 0.0
        self._time_us = message.time_us
        age_s = _difference(message.time_us, message.sample_time_us) * 1e-6
        self._rows.extend((before_s + max(step_us, 0) * 1e-6, time_s, age_s))
        self._rows.extend(float(getattr(message, name)) for name in _STATE.ordered_fieldnames)
        if len(self._rows) > self._most * len(COLUMNS):
            del self._rows[: len(COLUMNS) * (self._most // 10)]


def _difference(later_us: int, earlier_us: int) -> int:
    """Time from `earlier_us` to `later_us` on a clock that wraps at 2^30 us: from -2^29 on, to below 2^29."""
    return (later_us - earlier_us + _WRAP_US // 2) % _WRAP_US - _WRAP_US // 2
