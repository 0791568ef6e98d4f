"""The board's status light: a pattern for each state.

A pattern is sixteen slots of 131 ms, the first one the lowest bit; the clock's wrap is a whole number of patterns.
"""

from ..clock import ticks_diff
from ..generated_enums import KITE_MODE_MANUAL, KITE_MODE_PARK, KITE_MODE_STANDBY, KITE_MODE_TRACK

# Mostly dark: nothing steers. Mostly lit: the steering is live, and the dark gaps count the mode.
NO_LINK = 0x0001  # one flash
SETTINGS = 0x0005  # two flashes
STOPPED = 0x0015  # three flashes
NOT_STORED = 0x0055  # four flashes
DISARMED = 0x00FF  # a second on, a second off
STALE = 0x5555  # flickers
MANUAL = 0xFFFE  # one gap
PARK = 0xFFFA  # two gaps
TRACK = 0xFFEA  # three gaps

_SLOT_BITS = 17  # 2^17 us
_LOOK_BITS = 15  # it is looked at the state once in 2^15 us: four times a slot
_SLOTS = 15
_SILENCE_US = 3000000  # ground stations and bridges send more often
_BY_MODE = {KITE_MODE_MANUAL: MANUAL, KITE_MODE_PARK: PARK, KITE_MODE_TRACK: TRACK}


class StatusLight:
    """Shows patterns on `pin`, a callable that takes 0 or 1; never waits.

    `received()` gives a number that changes when bytes arrive on the link; without it the link counts as up.
    """

    def __init__(self, pin, received=None):
        self._pin = pin
        self._received = received
        self._count = received() if received else 0
        self._heard = 0
        self._linked = received is None
        self._lit = None
        self._looked = -1  # when it was last thought about [32 ms]
        self._storage_fails = None

    def show(self, mode, stale, now):
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

    def ask_storage(self, fails):
        """From now on also show that parameters cannot be read or saved: while `fails()`."""
        self._storage_fails = fails

    def show_pattern(self, pattern, now):
        """Set the light for `pattern` at `now`. The pin is written only when that changes."""
        lit = pattern >> (now >> _SLOT_BITS & _SLOTS) & 1
        if lit != self._lit:
            self._lit = lit
            self._pin(lit)

    def _follow_link(self, now):
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
