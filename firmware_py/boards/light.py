"""The board's status light: a pattern for each state.

A pattern is sixteen slots of 131 ms, the first one the lowest bit; the clock's wrap is a whole number of patterns.
"""

from ..clock import ticks_diff
from ..generated_enums import KITE_MODE_MANUAL, KITE_MODE_PARK, KITE_MODE_STANDBY, KITE_MODE_TRACK

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Final

# Mostly dark: nothing steers. Mostly lit: the steering is live, and the dark gaps count the mode.
NO_LINK = 0x0001  # type: Final  # one flash
SETTINGS = 0x0005  # type: Final  # two flashes
STOPPED = 0x0015  # type: Final  # three flashes
NOT_STORED = 0x0055  # type: Final  # four flashes
DISARMED = 0x00FF  # type: Final  # a second on, a second off
STALE = 0x5555  # type: Final  # flickers
MANUAL = 0xFFFE  # type: Final  # one gap
PARK = 0xFFFA  # type: Final  # two gaps
TRACK = 0xFFEA  # type: Final  # three gaps

_SLOT_BITS = 17  # type: Final  # 2^17 us
_LOOK_BITS = 15  # type: Final  # it is looked at the state once in 2^15 us: four times a slot
_SLOTS = 15  # type: Final
_SILENCE_US = 3000000  # type: Final  # ground stations and bridges send more often
_BY_MODE = {KITE_MODE_MANUAL: MANUAL, KITE_MODE_PARK: PARK, KITE_MODE_TRACK: TRACK}  # type: Final[dict[int, int]]


class StatusLight:
    """Shows patterns on `pin`, a callable that takes 0 or 1; never waits.

    `received()` gives a number that changes when bytes arrive on the link; without it the link counts as up.
    """

    def __init__(self, pin: "Callable[[int], object]", received: "Callable[[], int] | None" = None) -> None:
        self._pin = pin
        self._received = received
        self._count: int = received() if received else 0
        self._heard: int = 0
        self._linked: bool = received is None
        self._lit: int | None = None
        self._looked: int = -1  # when it was last thought about [32 ms]
        self._storage_fails: "Callable[[], bool] | None" = None

    def show(self, mode: int, stale: bool, now: int) -> None:
        """Show the state of the autopilot at `now` [us, wrapped]."""
        if now >> _LOOK_BITS == self._looked:
            return
        self._looked = now >> _LOOK_BITS
        self._follow_link(now)
        if mode == KITE_MODE_STANDBY:
            if self._storage_fails is not None and self._storage_fails():
                self.show_pattern(NOT_STORED, now)
            else:
                self.show_pattern(DISARMED if self._linked else NO_LINK, now)
        else:
            self.show_pattern(STALE if stale else _BY_MODE.get(mode, STALE), now)

    def ask_storage(self, fails: "Callable[[], bool] | None") -> None:
        """From now on also show that parameters cannot be read or saved: while `fails()`."""
        self._storage_fails = fails

    def show_pattern(self, pattern: int, now: int) -> None:
        """Set the light for `pattern` at `now`. The pin is written only when that changes."""
        lit = pattern >> (now >> _SLOT_BITS & _SLOTS) & 1
        if lit != self._lit:
            self._lit = lit
            self._pin(lit)

    def _follow_link(self, now: int) -> None:
        """Looked at each tick and kept, because the clock wraps."""
        if self._received is None:
            return
        count = self._received()
        if count != self._count:
            self._count = count
            self._heard = now
            self._linked = True
        elif self._linked and ticks_diff(now, self._heard) > _SILENCE_US:
            self._linked = False
