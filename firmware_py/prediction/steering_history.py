"""The commanded steering, and a model of the actuator's response: rate limit and saturation after a dead time.

Steering is counted in units of 2^-20: sums of integers are exact and allocate nothing, and every platform
gives the same ones. Time is counted in ticks of the loop.

The model takes one step a tick. What it did in a stretch of whole ticks is the difference of two running sums, so that
a long delay costs no more than a short one. A measured position leads to a path of its own: it is followed until it
meets the model's, or runs beside it at the actuator's limit.
"""

from ..parameters.generated_parameters import LOOP_HZ, PRED_RATE, PRED_SAT

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

ONE = 1 << 20  # type: Final  # steering of 1.0
ROOM = 256  # type: Final  # ticks that are remembered
_INDEX = ROOM - 1  # type: Final
_COUNTER = 0x3FFFFFFF  # type: Final
_SUM = 0x3FFFFFFF  # type: Final  # running sums wrap here: a small integer on boards
_HALF_SUM = 0x20000000  # type: Final
_STRETCH = 30  # type: Final  # ticks whose moment is less than half a wrap
_SAME = 4  # type: Final  # two positions this near are one: parts of a tick are rounded
_NO_LIMIT = 1 << 29  # type: Final
_SQUARABLE = 0x7FFF  # type: Final  # its square is a small integer on boards
_MOST = 1 << 21  # type: Final  # a measured steering beyond this is no steering


class SteeringHistory:
    """A ring buffer of each tick's commanded steering, and an actuator model that is run over it.

    The model is led to some tick by `begin`, and on by `advance`, which leaves what it did in `total` (steering times
    ticks), `moment` (the same weighted with the time from the middle of the stretch) and `position`.
    """

    def __init__(self) -> None:
        self._asked: list[int] = [0] * ROOM
        self._felt: list[int] = [0] * ROOM  # where the model is when that tick's steering begins to act
        self._sums: list[int] = [0] * ROOM  # S: of the mean positions of all ticks before, wrapped
        self._sums_of_sums: list[int] = [0] * ROOM  # of S up to here, less the first moments of the ticks before
        self._count: int = 0
        self._model: int = 0  # where it is when the next tick's will
        self._sum: int = 0  # S there
        self._sum_of_sums: int = 0
        self._limited: int = 0  # the newest ticks that the model spent at its rate limit, in one direction
        self._per_tick: int = _NO_LIMIT
        self._shift: int = 0
        self.saturation: int = ONE
        self._next: int = 0
        self._inner: int = 0
        self._on_model: bool = True  # what is advanced is on the model's path
        self.position: int = 0
        self.total: float = 0.0
        self.moment: float = 0.0

    def load(self, values: list[float]) -> None:
        """Take the actuator's limits over from the parameters' `values`."""
        rate = values[PRED_RATE]
        self._per_tick = max(1, min(_NO_LIMIT, int(rate / values[LOOP_HZ] * ONE))) if rate else _NO_LIMIT
        self._shift = 0
        while self._per_tick >> self._shift > _SQUARABLE:
            self._shift += 1
        self.saturation = int(values[PRED_SAT] * ONE) if values[PRED_SAT] else ONE

    def note(self, asked: float, ticks: int) -> None:
        """Store the steering commanded (`asked`) in this tick, `ticks` after the last one."""
        if ticks > 1:  # a loop that was held up: the actuator kept what it had
            for _ in range((ticks if ticks < ROOM else ROOM) - 1):
                self._push(self._asked[(self._count - 1) & _INDEX])
        self._push(round(asked * ONE))

    def begin(self, ticks: int, partial: float, measured: int | None) -> None:
        """Go to where the steering commanded `ticks` ago has `partial` of its tick left to act; 0 is all of it.

        There the actuator is at the `measured` steering, in the model's units, or at the model's own if None.
        """
        self._next = self._count - ticks
        self.position = self._felt[self._next & _INDEX] if ticks else self._model
        if partial:
            self._follow(self._next, self._limit(1.0 - partial))
        self._on_model = True
        if measured is not None:
            way = measured - self.position
            if not -_SAME <= way <= _SAME:
                self.position = measured if -_MOST < measured < _MOST else _MOST if measured > 0 else -_MOST
                self._on_model = False

    def advance(self, partial: float, ticks: int, tail: float) -> None:
        """Advance by `partial` of a tick, then `ticks` whole ones, then `tail` of one, all of which may be 0.

        In the tail, the last commanded steering is held.
        """
        before = first = moment = 0.0
        if partial:
            before = self._follow(self._next, self._limit(partial)) * partial
            first = self._inner * partial * partial
            self._next += 1
            self._on_model = self._on_model or self._meets_model()
        total = done = beside = 0  # of the whole ticks; the moment is about their beginning, the first tick's middle
        if not self._on_model:
            total, moment, done = self._follow_measured(ticks)
            if done < ticks and not self._on_model:
                beside = self.position - self._felt[self._next & _INDEX]
        while done < ticks:
            size = ticks - done if ticks - done < _STRETCH else _STRETCH
            start = self._next & _INDEX
            end = self._next = self._next + size
            if end == self._count:
                here = self._sum
                of_sums = self._sum_of_sums
                self.position = self._model + beside
            else:
                end &= _INDEX
                here = self._sums[end]
                of_sums = self._sums_of_sums[end]
                self.position = self._felt[end] + beside
            # All wrapped, here and in _push, without a function for it: each call of one takes a board 15 us.
            there = self._sums[start]
            stretch = ((here - there + _HALF_SUM) & _SUM) - _HALF_SUM
            of_sums = ((of_sums - self._sums_of_sums[start] + _HALF_SUM) & _SUM) - _HALF_SUM
            of_sums -= size * (there & 0x7FFF) + ((size * (there >> 15) & 0x7FFF) << 15)  # size * there, in 30 bits
            inside = size * stretch - (((of_sums + _HALF_SUM) & _SUM) - _HALF_SUM)
            if beside:
                stretch += beside * size
                inside += beside * (size * (size - 1) >> 1)
            moment += done * stretch + inside
            total += stretch
            done += size
        length = ticks + tail
        moment -= (0.5 * length - 0.5) * total
        if tail:
            mean = self._follow(self._count - 1, int(self._per_tick * tail) or 1)
            moment += tail * (tail * self._inner + 0.5 * ticks * mean)
            acted = total + tail * mean
        else:
            acted = total + 0.0
        if partial:
            moment += first + 0.5 * (acted * partial - before * length)
            acted += before
        self.total = acted
        self.moment = moment

    def _follow_measured(self, ticks: int) -> tuple[int, float, int]:
        """Go on through up to `ticks`, until the path meets the model's or runs beside it: total, moment, ticks gone.

        The path is one that began at a measured position.
        """
        total = done = 0
        moment = 0.0
        while done < ticks and not self._on_model:
            if abs(self._limited) >= self._count - self._next and self._runs_beside(ticks - done):
                break
            mean = self._follow(self._next, self._per_tick)
            self._next += 1
            total += mean
            moment += done * mean + self._inner
            done += 1
            self._on_model = self._meets_model()
        return total, moment, done

    def _meets_model(self) -> bool:
        """True if the path that is followed has come to the model's, at the beginning of a tick."""
        model = self._model if self._next == self._count else self._felt[self._next & _INDEX]
        if -_SAME <= self.position - model <= _SAME:
            self.position = model
            return True
        return False

    def _runs_beside(self, ticks: int) -> bool:
        """True if a path beside a model that is at its limit is so too for `ticks`, and stays as far from it.

        One that is ahead may reach its target earlier; it is taken to run beside only where that makes no difference to
        speak of, of less than the limit's way in a tick.
        """
        beside = self.position - self._felt[self._next & _INDEX]
        ahead = beside if self._limited > 0 else -beside
        if ahead <= 0:
            return True
        if ahead > self._per_tick:
            return False
        end = self._next + ticks
        model = self._model if end == self._count else self._felt[end & _INDEX]
        left = max(-self.saturation, min(self.saturation, self._asked[(end - 1) & _INDEX])) - model
        return left >= beside if self._limited > 0 else left <= beside

    def _push(self, asked: int) -> None:
        count = self._count
        index = count & _INDEX
        per_tick = self._per_tick
        total = self._sum
        of_sums = self._sum_of_sums
        before = self.position = self._model
        self._asked[index] = asked
        self._felt[index] = before
        self._sums[index] = total
        self._sums_of_sums[index] = of_sums
        mean = self._follow(index, per_tick)
        after = self._model = self.position
        total = self._sum = ((total + mean + _HALF_SUM) & _SUM) - _HALF_SUM
        self._sum_of_sums = ((of_sums + total - self._inner + _HALF_SUM) & _SUM) - _HALF_SUM
        self._count = (count + 1) & _COUNTER
        way = after - before
        if way == per_tick:
            self._limited = self._limited + 1 if self._limited > 0 else 1
        elif way == -per_tick:
            self._limited = self._limited - 1 if self._limited < 0 else -1
        else:
            self._limited = 0

    def _limit(self, share: float) -> int:
        """How far the actuator gets in this share of a tick."""
        return int(self._per_tick * share) or 1

    def _follow(self, tick: int, limit: int) -> int:
        """Move on through a tick, or a part of one in which the actuator gets `limit` far; return the mean position.

        A ramp over the share x of it, then rest. `_inner` is its first moment, d (x / 4 - x^2 / 6) for a way of d.
        """
        target = self._asked[tick & _INDEX]
        if target > self.saturation:
            target = self.saturation
        elif target < -self.saturation:
            target = -self.saturation
        position = self.position
        way = target - position
        size = way if way > 0 else -way
        if size >= limit:
            inner = limit // 12
            if way > 0:
                self._inner = inner
                self.position = position + limit
                return position + (limit >> 1)
            self._inner = -inner
            self.position = position - limit
            return position - (limit >> 1)
        self.position = target
        if not size:
            self._inner = 0
            return target
        shift = self._shift
        size >>= shift
        limit = limit >> shift or 1
        short = (size * size // (2 * limit)) << shift
        inner = (short >> 1) - short * (size >> 5) // (3 * (limit >> 5 or 1))
        if way > 0:
            self._inner = inner
            return target - short
        self._inner = -inner
        return target + short
