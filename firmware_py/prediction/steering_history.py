"""The commanded steering, and a model of the actuator's response: rate limit and saturation after a dead time.

Steering is counted in units of 2^-20: sums of integers are exact and allocate nothing, and every platform
gives the same ones. Time is counted in ticks of the loop.
"""

from array import array

from ..parameters.generated_parameters import LOOP_HZ, PRED_RATE, PRED_SAT

ONE = 1 << 20  # steering of 1.0
ROOM = 256  # ticks that are remembered
_INDEX = ROOM - 1
_COUNTER = 0x3FFFFFFF
_NO_LIMIT = 1 << 29
_SQUARABLE = 0x7FFF  # its square is a small integer on boards
_MOST = 1 << 21  # a measured steering beyond this is no steering


class SteeringHistory:
    """A ring buffer of each tick's commanded steering, and an actuator model that is run over it.

    The model is led to some tick by `begin`, and on by `advance`, which leaves what it did in `total` (steering times
    ticks), `moment` (the same weighted with the time from the middle of the stretch) and `position`.
    """

    def __init__(self):
        self._asked = array("i", [0] * ROOM)
        self._felt = array("i", [0] * ROOM)  # where the model is when that tick's steering begins to act
        self._count = 0
        self._model = 0  # where it is when the next tick's will
        self._per_tick = _NO_LIMIT
        self._shift = 0
        self.saturation = ONE
        self._next = 0
        self._inner = 0
        self.position = 0
        self.total = 0.0
        self.moment = 0.0

    def load(self, values):
        """Take the actuator's limits over from the parameters' `values`."""
        rate = values[PRED_RATE]
        self._per_tick = max(1, min(_NO_LIMIT, int(rate / values[LOOP_HZ] * ONE))) if rate else _NO_LIMIT
        self._shift = 0
        while self._per_tick >> self._shift > _SQUARABLE:
            self._shift += 1
        self.saturation = int(values[PRED_SAT] * ONE) if values[PRED_SAT] else ONE

    def note(self, asked, ticks):
        """Store the steering commanded (`asked`) in this tick, `ticks` after the last one."""
        ticks = min(ticks, ROOM)
        while ticks > 1:  # a loop that was held up: the actuator kept what it had
            self._push(self._asked[(self._count - 1) & _INDEX])
            ticks -= 1
        self._push(round(asked * ONE))

    def begin(self, ticks, partial, measured):
        """Go to where the steering commanded `ticks` ago has `partial` of its tick left to act; 0 is all of it.

        There the actuator is at the `measured` steering, in the model's units, or at the model's own if None.
        """
        self._next = self._count - ticks
        if measured is not None:
            self.position = max(-_MOST, min(_MOST, measured))
        elif ticks:
            self.position = self._felt[self._next & _INDEX]
            if partial:
                self._follow(self._next, self._limit(1.0 - partial))
        else:
            self.position = self._model

    def advance(self, partial, ticks, tail):
        """Advance by `partial` of a tick, then `ticks` whole ones, then half of one if `tail`.

        In that half, the last commanded steering is held.
        """
        before = moment = 0.0
        if partial:
            before = self._follow(self._next, self._limit(partial)) * partial
            moment = self._inner * partial * partial
            self._next += 1
        total = weighted = inner = 0
        for index in range(ticks):
            mean = self._follow(self._next, self._per_tick)
            self._next += 1
            total += mean
            weighted += index * mean
            inner += self._inner
        total *= 2  # in half ticks, and the moment in eighths
        eighths = 8 * (weighted + inner) + 2 * total
        length = ticks
        if tail:
            mean = self._follow(self._count - 1, self._per_tick >> 1 or 1)
            total += mean
            eighths += mean * (4 * ticks + 1) + 2 * self._inner
            length += 0.5
            eighths -= (2 * ticks + 1) * total
        else:
            eighths -= 2 * ticks * total
        self.total = 0.5 * total
        self.moment = 0.125 * eighths
        if partial:
            self.moment += moment + 0.5 * (self.total * partial - before * length)
            self.total += before

    def _push(self, asked):
        index = self._count & _INDEX
        self._asked[index] = asked
        self._felt[index] = self.position = self._model
        self._follow(index, self._per_tick)
        self._model = self.position
        self._count = (self._count + 1) & _COUNTER

    def _limit(self, share):
        """How far the actuator gets in this share of a tick."""
        return max(1, int(self._per_tick * share))

    def _follow(self, tick, limit):
        """Move on through a tick, or a part of one in which the actuator gets `limit` far; return the mean position.

        A ramp over the share x of it, then rest. `_inner` is its first moment, d (x / 4 - x^2 / 6) for a way of d.
        """
        target = max(-self.saturation, min(self.saturation, self._asked[tick & _INDEX]))
        way = target - self.position
        size = abs(way)
        if size >= limit:
            mean = limit >> 1
            self._inner = limit // 12
            if way > 0:
                mean += self.position
                self.position += limit
            else:
                mean = self.position - mean
                self.position -= limit
                self._inner = -self._inner
            return mean
        shift = self._shift
        size >>= shift
        limit = max(1, limit >> shift)
        short = (size * size // (2 * limit)) << shift
        inner = (short >> 1) - short * (size >> 5) // (3 * max(1, limit >> 5))
        self.position = target
        if way > 0:
            self._inner = inner
            return target - short
        self._inner = -inner
        return target + short
