"""All KITE_STATE messages received: the flight so far."""

import threading
from array import array
from typing import TYPE_CHECKING

from ground.link.framing import Message
from protocol import dialect
from protocol.clock import RunningClock, nearest_us

if TYPE_CHECKING:
    import numpy as np

    from kite_analysis.flights.record import FlightRecord

_STATE = dialect.MAVLink_kite_state_message
COLUMNS = ("time_s", "heard_s", "sample_age_s", *_STATE.ordered_fieldnames)


class StateHistory:
    """The flight so far, a row for each KITE_STATE, oldest first; at most the latest `most` rows.

    `time_s` is the vehicle's clock at the tick, unwrapped, from the first row on; `heard_s` is the ground's clock on
    arrival; `sample_age_s` is the age of the newest sample at that tick, if sensors and firmware share a clock. When
    the vehicle restarts, `time_s` continues by the time that passed on the ground.

    One thread may observe while others read: the array cannot grow while numpy copies it, hence the lock.
    """

    def __init__(self, most: int = 200_000) -> None:
        self._rows = array("d")
        self._most = most
        self._clock = RunningClock()
        self._age_us = 0
        self._newest_s: float | None = None
        self._lock = threading.Lock()

    def __len__(self) -> int:
        with self._lock:
            return len(self._rows) // len(COLUMNS)

    @property
    def newest_s(self) -> float | None:
        """`time_s` of the newest row, or None before the first."""
        return self._newest_s

    def __getitem__(self, column: str) -> "np.ndarray":
        """One of COLUMNS, shape (n,): a time [s], or a field of KITE_STATE in its unit."""
        return self._columns()[column]

    def record(self, seconds: float | None = None) -> "FlightRecord":
        """The last `seconds` [s] of the vehicle's time, or all of it; `heard_s` is in `further`.

        Raises:
            ValueError: `seconds` is not a positive time.
        """
        from kite_analysis.flights.telemetry import record_of_states  # noqa: PLC0415  (numpy, and slow to load)

        if seconds is not None and not seconds > 0.0:
            raise ValueError(f"the last {seconds:g} s: must be more than 0")
        columns = self._columns()
        fields = {name: columns[name] for name in _STATE.ordered_fieldnames}
        flight = record_of_states(fields, columns["time_s"], columns["sample_age_s"], "this flight",
                                  {"heard_s": columns["heard_s"]})
        if seconds is None or not len(flight.time_s):
            return flight
        return flight.rows(flight.time_s > flight.time_s[-1] - seconds)

    def observe(self, time_s: float, message: Message, frame: bytes) -> None:
        """Add one of the vehicle's messages, as an observer of a connection."""
        if not isinstance(message, _STATE):
            return
        with self._lock:
            self._add(time_s, message)

    def _columns(self) -> "dict[str, np.ndarray]":
        """All COLUMNS by name, each of shape (n,)."""
        import numpy as np  # noqa: PLC0415  (slow to load, and most verbs do without)

        with self._lock:
            rows = np.array(self._rows).reshape(-1, len(COLUMNS))
        return dict(zip(COLUMNS, rows.T, strict=True))

    def _add(self, heard_s: float, message: _STATE) -> None:
        tick_s = self._clock.elapsed_s(message.time_us, heard_s)
        if self._newest_s is not None and tick_s < self._newest_s:
            return  # overtaken on the way
        self._newest_s = tick_s
        self._age_us = nearest_us(message.time_us - message.sample_time_us, self._age_us)
        self._rows.extend((tick_s, heard_s, self._age_us * 1e-6))
        self._rows.extend(float(getattr(message, name)) for name in _STATE.ordered_fieldnames)
        if len(self._rows) > self._most * len(COLUMNS):
            del self._rows[: len(COLUMNS) * (self._most // 10)]
