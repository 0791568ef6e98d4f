"""Progress of a flight, on a terminal only."""

import sys
from types import TracebackType

from tqdm import tqdm

from sim_bridge.flight.flight import Flight

_PATIENCE_S = 1.0  # a flight that is over sooner shows nothing


class FlightProgress:
    """A bar over the seconds flown, out of `seconds` (None: no end); it is gone when the flight is over."""

    def __init__(self, seconds: float | None, wanted: bool):
        self._bar = tqdm(total=seconds, unit="s", leave=False, delay=_PATIENCE_S, file=sys.stderr,
                         bar_format="{percentage:3.0f}% |{bar}| {n:.0f} of {total:.0f} s flown, {remaining} left"
                         if seconds else "{n:.0f} s flown in {elapsed}",
                         disable=None if wanted else True)

    def __call__(self, flight: Flight) -> None:
        """Show how far `flight` is."""
        self._bar.update(flight.time_s - self._bar.n)

    def __enter__(self) -> "FlightProgress":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self._bar.close()
