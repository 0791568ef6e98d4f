"""docs/modes.md, "Modes" and "Parameters", as an oracle: what is obeyed, late, taken and refused.

The last command that was asked for is the mode. TRACK and ARM wait for the check of the eight for some ticks, so what
became of them is read from their acknowledgement, and judged.
"""

from collections import deque
from typing import TYPE_CHECKING, Any, NamedTuple

from documented_eight import can_be_flown
from documented_output import DivergenceError
from documented_samples import SECOND
from firmware_bench import ARM, DO_SET_MODE, MANUAL, PARK, STANDBY, TRACK

from protocol import dialect
from protocol.parameter_table import float32, load_parameters

if TYPE_CHECKING:
    from documented_modes import Documented, Seen

ACCEPTED, REJECTED = dialect.MAV_RESULT_ACCEPTED, dialect.MAV_RESULT_TEMPORARILY_REJECTED
LATE_US = 3 * SECOND
REMEMBERED = 8  # commands, of all stations
BEHIND = 32  # numbers; a station that is further behind has begun anew
PATIENCE_TICKS = 100  # in which a command that waits for the check of the eight is answered
CURVE = ("EIGHT_AZIMUTH", "EIGHT_ELEVATION", "EIGHT_HALF_H", "EIGHT_HALF_W", "EIGHT_LEAST_EL", "LINE_LENGTH",
         "STEER_MAX", "TURN_K", "WINDOW_ANGLE")
ARMING, DISARMING = "ARM", "DISARM"
MODES = {"STANDBY": STANDBY, "MANUAL": MANUAL, "PARK": PARK, "TRACK": TRACK}
WORDS = {mode: word for word, mode in MODES.items()}


class Frame(NamedTuple):
    """A frame as it arrived: `station` is (system, component)."""

    station: tuple[int, int]
    sequence: int
    message: Any

    @property
    def wish(self) -> str | None:
        """What an arm, disarm or mode command asks for."""
        message = self.message
        if message.get_type() != "COMMAND_LONG":
            return None
        if message.command == ARM:
            return ARMING if message.param1 else DISARMING
        return WORDS[int(message.param2)] if message.command == DO_SET_MODE else None


class Done(NamedTuple):
    """A mode command that was obeyed, or overtaken while it waited."""

    frame: Frame
    at_us: int


def behind(frame: Frame, done: Done) -> int:
    """By how many numbers a frame is behind one that was done [0 to 255]; 0 is a copy of it."""
    return (done.frame.sequence - frame.sequence) % 256


class Waiting:
    """A TRACK or ARM that is not answered yet, or a mode command that waits behind an ARM."""

    def __init__(self, frame: Frame, order: int, doubtful: bool = False, overtaken: bool = False):
        self.frame = frame
        self.order = order
        self.doubtful = doubtful  # it may be rejected
        self.overtaken = overtaken  # it must be rejected
        self.ticks = 0


class Commands:
    """Commands and parameter sets of all stations, for one `flight`."""

    def __init__(self, flight: "Documented"):
        self._flight = flight
        self._done: deque[Done] = deque(maxlen=64)
        self._heard: deque[Frame] = deque(maxlen=16)
        self._order = 0
        self._waiting: list[Waiting] = []
        self._expected: list[tuple[Frame, set[int]]] = []  # acknowledgements of this tick
        self._values: list[tuple[str, float]] = []  # PARAM_VALUEs of this tick
        self._errors = 0  # PARAM_ERRORs of this tick
        self._checked: dict[str, list[float]] = {}  # values that wait for the check of the eight
        self._ticks: deque[int] = deque([0], maxlen=64)  # commands and sets by tick

    def story(self) -> str:
        """The last commands, for the text of an error."""
        done = [f"{entry.frame.wish} from {entry.frame.station[0]} #{entry.frame.sequence} at {entry.at_us}"
                for entry in list(self._done)[-4:]]
        heard = [f"{frame.wish} from {frame.station[0]} #{frame.sequence}" for frame in list(self._heard)[-6:]]
        return f"now {self._flight.now}, heard {heard}, done {done}"

    def recent(self, ticks: int) -> int:
        """How many commands and sets came within the last `ticks`."""
        return sum(list(self._ticks)[-ticks:])

    @property
    def waiting(self) -> int:
        """How many commands and sets wait for the check of the eight."""
        return len(self._waiting) + sum(map(len, self._checked.values()))

    def is_clear_copy(self, frame: Frame) -> bool:
        """Whether the page says what a copy of `frame` does that arrives now."""
        now = self._flight.now
        mine = [entry for entry in self._done if entry.frame.station == frame.station]
        if any(abs(now - entry.at_us - LATE_US) < SECOND // 10 for entry in mine):
            return False
        if sum(now - entry.at_us < LATE_US for entry in self._done) > REMEMBERED:
            return False
        recent = self._recent(frame.station)
        if not recent:
            return True
        if frame.wish in ("TRACK", ARMING):
            return behind(frame, recent[-1]) <= BEHIND
        return any(entry.frame.sequence == frame.sequence for entry in recent)  # else an old PARK after newer commands

    def hear(self, frame: Frame) -> None:
        """A COMMAND_LONG or PARAM_SET arrived; anything else asks for nothing that the page speaks of."""
        if frame.message.get_type() == "PARAM_SET":
            self._ticks[-1] += 1
            self._set(frame)
        elif frame.wish is not None:
            self._ticks[-1] += 1
            self._command(frame, frame.wish)

    # A late copy is not a new command

    def _command(self, frame: Frame, wish: str) -> None:
        flight = self._flight
        copied = frame in self._heard
        self._heard.append(frame)
        if self._is_late(frame, wish) or (copied and self._is_so(wish)):
            for other in self._waiting:
                other.doubtful = True
            if self._is_so(wish):
                self._expect(frame, {ACCEPTED, REJECTED})
            elif wish in ("TRACK", ARMING):
                self._waiting.append(Waiting(frame, self._order, overtaken=True))
            else:
                self._expect(frame, {REJECTED})
            return
        flight.hear_operator()
        self._order += 1
        in_order = not flight.armed and any(other.frame.wish == ARMING for other in self._waiting)
        for other in self._waiting:
            ends = wish in (DISARMING, "STANDBY")
            other.overtaken |= ends or (not in_order and other.frame.wish == "TRACK" != wish)
            other.doubtful = True
        for other, results in self._expected:
            if other.wish in ("MANUAL", "TRACK", ARMING):
                results.add(REJECTED)  # overtaken in its own tick
        self._obey(frame, wish)

    def _is_late(self, frame: Frame, wish: str) -> bool:
        recent = self._recent(frame.station)
        if not recent or self._is_so(wish):
            return False
        if wish in ("TRACK", ARMING):
            return behind(frame, recent[-1]) <= BEHIND
        return any(entry.frame.sequence == frame.sequence and entry.frame.wish == wish for entry in recent)

    def _recent(self, station: tuple[int, int]) -> list[Done]:
        """What a station's commands did within 3 s."""
        now = self._flight.now
        return [entry for entry in self._done if entry.frame.station == station and now - entry.at_us < LATE_US]

    def _note(self, frame: Frame) -> None:
        self._done.append(Done(frame, self._flight.now))

    def _is_so(self, wish: str) -> bool:
        flight = self._flight
        return flight.armed if wish == ARMING else not flight.armed if wish == DISARMING else WORDS[flight.mode] == wish

    # The last command is the mode

    def _obey(self, frame: Frame, wish: str) -> None:
        flight = self._flight
        if wish in (DISARMING, "STANDBY"):
            flight.enter(STANDBY)
            self._accept(frame)
        elif wish in ("PARK", "MANUAL") and flight.armed:
            flight.enter(MODES[wish])
            self._accept(frame)
        elif self._is_so(wish) and not (wish == "TRACK" and flight.stale):
            self._accept(frame)
        else:
            self._waiting.append(Waiting(frame, self._order, doubtful=wish != ARMING and not flight.armed))

    def _accept(self, frame: Frame) -> None:
        self._note(frame)
        self._expect(frame, {ACCEPTED})

    def _expect(self, frame: Frame, results: set[int]) -> None:
        self._expected.append((frame, results))

    def settle(self, seen: "Seen") -> None:
        """Hold the answers of a tick against what was asked."""
        answers = [((ack.target_system, ack.target_component), ack.command, ack.result)
                   for ack in seen.of_kind("COMMAND_ACK")]
        for frame, results in sorted(self._expected, key=lambda entry: len(entry[1])):
            fitting = [answer for answer in answers
                       if answer[:2] == (frame.station, frame.message.command) and answer[2] in results]
            if not fitting:
                raise DivergenceError(
                    f"{frame.wish} is " + ("not acknowledged at once" if len(results) > 1 else "refused"
                                           if ACCEPTED in results else "not rejected"), f"{answers}; {self.story()}")
            others_lose = any(waiting.overtaken for waiting in self._waiting_of(*fitting[0][:2]))
            answers.remove(sorted(fitting, key=lambda answer: (answer[2] == ACCEPTED) != others_lose)[0])
        for station, command, result in answers:
            self._settle_waiting(station, command, result)
        self._expected = []
        for waiting in self._waiting:
            waiting.ticks += 1
            if waiting.ticks > PATIENCE_TICKS:
                raise DivergenceError(f"{waiting.frame.wish} is never answered", self.story())
        self._settle_sets(seen)
        self._ticks.append(0)

    def _waiting_of(self, station: tuple[int, int], command: int) -> list[Waiting]:
        return [waiting for waiting in self._waiting
                if waiting.frame.station == station and waiting.frame.message.command == command]

    def _settle_waiting(self, station: tuple[int, int], command: int, result: int) -> None:
        mine = self._waiting_of(station, command)
        if not mine:
            if command in (ARM, DO_SET_MODE):
                raise DivergenceError("an acknowledgement too many", f"{station} {command} {result}; {self.story()}")
            return
        if result == ACCEPTED:
            chosen = min(mine, key=lambda waiting: (waiting.overtaken, waiting.order))  # they follow in their order
            self._accepted(chosen)
        else:
            chosen = max(mine, key=lambda waiting: (waiting.overtaken, waiting.doubtful, -waiting.order))
            self._rejected(chosen)
        self._waiting.remove(chosen)

    def _accepted(self, waiting: Waiting) -> None:
        flight, wish = self._flight, waiting.frame.wish or ""
        if waiting.overtaken:
            raise DivergenceError(f"{wish} is accepted though it was overtaken", self.story())
        self._note(waiting.frame)
        if self._is_so(wish):
            return
        if wish == ARMING:
            if flight.samples.is_old(flight.now):
                raise DivergenceError("armed without fresh samples")
            flight.stale = False
        elif not flight.armed:
            raise DivergenceError(f"{wish} is accepted before ARM", self.story())
        if wish == "TRACK" and flight.stale:
            raise DivergenceError("TRACK is accepted while samples are stale", self.story())
        if wish in ("TRACK", ARMING) and self._flyable() is False:
            raise DivergenceError(f"{wish} is accepted with an eight that cannot be flown")
        flight.enter(PARK if wish == ARMING else MODES[wish])

    def _rejected(self, waiting: Waiting) -> None:
        flight = self._flight
        if not (waiting.overtaken or waiting.doubtful or flight.stale or self._flyable() is not True):
            raise DivergenceError(f"{waiting.frame.wish} is refused without a reason", self.story())
        if waiting.overtaken:
            self._note(waiting.frame)

    def _flyable(self) -> bool | None:
        return can_be_flown(self._flight.parameters)

    # Parameters: a set is taken or refused as a whole

    def _set(self, frame: Frame) -> None:
        flight, message = self._flight, frame.message
        entry = load_parameters().get(message.param_id)
        value = float32(message.param_value)
        if entry is None or entry.read_only or entry.problem_with(value) or (entry.disarmed_only and flight.armed):
            self._errors += 1
            if entry is not None:
                self._values.append((entry.name, flight.parameters[entry.name]))
        elif entry.name in CURVE and (flight.mode == TRACK or self._checked.get(entry.name)):
            self._checked.setdefault(entry.name, []).append(value)
        else:
            flight.parameters[entry.name] = value
            self._values.append((entry.name, value))
        if entry is not None and entry.name in CURVE:
            for waiting in self._waiting:
                waiting.doubtful = True  # the eight is being changed

    def _settle_sets(self, seen: "Seen") -> None:
        flight = self._flight
        for name, values in list(self._checked.items()):
            if seen.parameters[name] in values:
                flight.parameters[name] = seen.parameters[name]
            answers = [value.param_value for value in seen.of_kind("PARAM_VALUE") if value.param_id == name]
            for value in answers:  # taken, or refused and told what holds
                values.remove(value if value in values else values[0])
                if not values:
                    del self._checked[name]
                    break
        if not self._checked and seen.parameters != flight.parameters:
            wrong = {name: (value, seen.parameters[name]) for name, value in flight.parameters.items()
                     if seen.parameters[name] != value}
            raise DivergenceError("a parameter is not what was set", f"(page, firmware): {wrong}")
        if self._values and not self._checked:
            told = [(value.param_id, value.param_value) for value in seen.of_kind("PARAM_VALUE")]
            for name, value in self._values:
                if (name, value) not in told:
                    raise DivergenceError("a set is not answered with the value that holds", f"{name} {value}, {told}")
            if len(seen.of_kind("PARAM_ERROR")) < self._errors:
                raise DivergenceError("a set is refused without PARAM_ERROR")
        self._values, self._errors = [], 0
