"""Limit on recorded ground-station input: a flood must not fill the disk."""

_BURST_BYTES = 1e6
_RATE_BYTES_S = 10e3  # twice what a telemetry radio carries
_OVERHEAD_BYTES = 8  # of a datagram, so that a flood of empty ones counts


class InputBudget:
    """Bytes of datagrams that a log takes: a burst, and an average rate."""

    text = f"{_BURST_BYTES / 1e6:g} MB and {_RATE_BYTES_S / 1e3:g} kB/s"

    def __init__(self) -> None:
        self.left_out = 0  # bytes for which there was no room
        self._room = _BURST_BYTES
        self._time_s = float("-inf")

    def claim_room(self, time_s: float, size: int) -> bool:
        """Take `size` [bytes] at `time_s` [s] of the flight; False, and counted, if there is no room for them."""
        self._room = min(_BURST_BYTES, self._room + max(0.0, time_s - self._time_s) * _RATE_BYTES_S)
        self._time_s = time_s
        size += _OVERHEAD_BYTES
        if size > self._room:
            self.left_out += size
            return False
        self._room -= size
        return True
