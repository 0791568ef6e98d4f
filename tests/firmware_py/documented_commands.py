"""docs/modes.md, "Modes" and "Parameters", as an oracle: what is obeyed, late, taken and refused.

The last command that was asked for is the mode. TRACK and ARM wait for the check of the eight for some ticks: when they
are answered is read from the acknowledgements, and the answer is judged.
"""

from collections import deque
from typing import TYPE_CHECKING, Any, NamedTuple

from documented_eight import can_be_flown
from documented_output import DivergenceError
from documented_samples import SECOND
from firmware_bench import ARM, DO_SET_MODE, MANUAL, PARK, STANDBY, TRACK

from protocol import dialect
from protocol.parameter_table import load_parameters
from protocol.single_precision import float32

if TYPE_CHECKING:
    from documented_modes import Documented, Seen

ACCEPTED, REJECTED = dialect.MAV_RESULT_ACCEPTED, dialect.MAV_RESULT_TEMPORARILY_REJECTED
LATE_US = 3 * SECOND
LATE_TEXT = "overtaken by a later command"
REMEMBERED = 8  # answers, to all stations
BEHIND = 32  # numbers; a station that is further behind has begun anew
ROOM = 8  # commands that may wait for the check of the eight
PATIENCE_TICKS = 100  # in which they are answered; so are sets, after the last question: pings' answers are short
REFUSALS_ROOM = 8  # PARAM_ERRORs that may wait for room on the link
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
    """An arm, disarm or mode command that was answered; obeyed or overtaken, unless it was `refused`."""

    frame: Frame
    at_us: int
    refused: bool


def behind(frame: Frame, done: Done) -> int:
    """By how many numbers a frame is behind one that was done [0 to 255]; 0 is a copy of it."""
    return (done.frame.sequence - frame.sequence) % 256


class Waiting:
    """A command that waits for the check of the eight, or behind one that does."""

    def __init__(self, frame: Frame):
        self.frame = frame
        self.restless = False  # the eight was changed meanwhile: it may be refused
        self.ticks = 0


class Commands:
    """Commands and parameter sets of all stations, for one `flight`."""

    def __init__(self, flight: "Documented"):
        self._flight = flight
        self._done: deque[Done] = deque(maxlen=REMEMBERED)
        self._heard: deque[Frame] = deque(maxlen=16)
        self._waiting: list[Waiting] = []  # in their order
        self._expected: list[tuple[Frame, set[int]]] = []  # acknowledgements of this tick
        self._late: list[tuple[Frame, set[int]]] = []  # those of late copies
        self._values: set[str] = set()  # parameters of which a PARAM_VALUE must come
        self._errors: list[str] = []  # names of the PARAM_ERRORs that must come
        self._checked: dict[str, list[float]] = {}  # values that wait for the check of the eight
        self._unanswered: set[str] = set()  # those of which no PARAM_VALUE has come since the last was sent
        self._since_checked = 0  # ticks since the last of them was sent
        self._since_question = PATIENCE_TICKS  # ticks: the link is not crowded
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

    def hear(self, frame: Frame) -> None:
        """A COMMAND_LONG, a PARAM_SET or a question arrived; the answer to this one takes room on the link."""
        if frame.message.get_type() == "PARAM_SET":
            self._ticks[-1] += 1
            self._set(frame)
        elif frame.wish is not None:
            self._ticks[-1] += 1
            self._heard.append(frame)
            self._command(frame, frame.wish)
        else:
            self._since_question = 0

    # A late copy is not a new command

    def _command(self, frame: Frame, wish: str) -> None:
        if self._is_late(frame, wish):
            self._late.append((frame, {self._late_result(wish)}))
            return
        self._flight.hear_operator()
        self._overtake(wish)
        self._obey(frame, wish)

    def _is_late(self, frame: Frame, wish: str) -> bool:
        """This very frame was answered, or it is a TRACK or ARM from before one that was not refused."""
        now = self._flight.now
        recent = [done for done in self._done if done.frame.station == frame.station and now - done.at_us < LATE_US]
        return any(
            (done.frame.sequence == frame.sequence and done.frame.wish == wish)
            or (wish in ("TRACK", ARMING) and not done.refused and behind(frame, done) <= BEHIND) for done in recent)

    def _late_result(self, wish: str) -> int:
        return ACCEPTED if self._is_so(wish) else REJECTED

    def _tell_late(self, frame: Frame) -> None:
        """The operator is told, unless the reason of a refusal was told when the frame came first."""
        if not any(done.refused and done.frame == frame for done in self._done):
            self._flight.owe(LATE_TEXT)

    def _is_so(self, wish: str) -> bool:
        flight = self._flight
        return flight.armed if wish == ARMING else not flight.armed if wish == DISARMING else WORDS[flight.mode] == wish

    def _note(self, frame: Frame, refused: bool = False) -> None:
        self._done.append(Done(frame, self._flight.now, refused))

    # The last command is the mode

    def _overtake(self, wish: str) -> None:
        flight = self._flight
        ends = wish in (DISARMING, "STANDBY")
        if ends or (flight.armed and not self._must_wait(wish)):
            for waiting in self._waiting:
                self._answer(waiting.frame, REJECTED, refused=False)
            self._waiting = []
        if ends or (flight.armed and wish == "PARK"):
            for index, (other, _) in enumerate(self._expected):
                if other.wish in ("MANUAL", "TRACK", ARMING):  # of the same tick
                    self._expected[index] = (other, {REJECTED})
                    self._done = deque((done._replace(refused=False) if done.frame is other else done
                                        for done in self._done), maxlen=REMEMBERED)

    def _must_wait(self, wish: str) -> bool:
        flight = self._flight
        if flight.armed:
            return wish == "TRACK" and flight.mode != TRACK
        return wish in ("TRACK", ARMING) or (bool(self._waiting) and wish in ("PARK", "MANUAL"))

    def _obey(self, frame: Frame, wish: str) -> None:
        if self._must_wait(wish):
            if len(self._waiting) < ROOM:
                self._waiting.append(Waiting(frame))
            else:
                self._answer(frame, REJECTED)
        elif self._reason_against(wish):
            self._answer(frame, REJECTED)
        else:
            self._answer(frame, ACCEPTED)
            self._do(wish)

    def _do(self, wish: str) -> None:
        flight = self._flight
        if wish == ARMING:
            if not flight.armed:
                flight.stale = False
                flight.enter(PARK)
        else:
            flight.enter(STANDBY if wish == DISARMING else MODES[wish])

    def _reason_against(self, wish: str) -> str:
        """What the page says against a command, the check of the eight apart; none if it must be obeyed."""
        flight = self._flight
        if wish == ARMING and not flight.armed and flight.samples.is_old(flight.now):
            return "without fresh samples"
        if wish in ("PARK", "MANUAL", "TRACK") and not flight.armed:
            return "before ARM"
        return "while samples are stale" if wish == "TRACK" and flight.stale else ""

    def _answer(self, frame: Frame, result: int, refused: bool | None = None) -> None:
        self._note(frame, result != ACCEPTED if refused is None else refused)
        self._expected.append((frame, {result}))

    def settle(self, seen: "Seen") -> None:
        """Hold the answers of a tick against what was asked."""
        answers = [((ack.target_system, ack.target_component), ack.command, ack.result)
                   for ack in seen.of_kind("COMMAND_ACK") if ack.command in (ARM, DO_SET_MODE)]
        for frame, results in self._late:
            if self._ticks[-1] > 1:
                results |= {ACCEPTED, REJECTED}  # what it asks for may have been so for a part of the tick
            if results == {REJECTED}:
                self._tell_late(frame)
        expected = self._expected + self._late
        turn = answers.pop() if len(answers) > len(expected) else None  # what waits is answered last
        for frame, results in expected:
            fitting = [answer for answer in answers
                       if answer[:2] == (frame.station, frame.message.command) and answer[2] in results]
            if not fitting:
                raise DivergenceError(f"{frame.wish} is " + ("refused" if ACCEPTED in results else "not rejected"),
                                      f"{answers}; {self.story()}")
            answers.remove(fitting[0])
        self._expected, self._late = [], []
        if answers:
            raise DivergenceError("an acknowledgement too many", f"{answers}; {self.story()}")
        if turn:
            self._settle_waiting(*turn)
        for waiting in self._waiting:
            waiting.ticks += 1
            if waiting.ticks > PATIENCE_TICKS:
                raise DivergenceError(f"{waiting.frame.wish} is never answered", self.story())
        self._settle_sets(seen)
        self._ticks.append(0)

    def _settle_waiting(self, station: tuple[int, int], command: int, result: int) -> None:
        """The one that has waited longest is answered."""
        first = self._waiting.pop(0) if self._waiting else None
        if first is None or (first.frame.station, first.frame.message.command) != (station, command):
            raise DivergenceError("an acknowledgement too many", f"{station} {command} {result}; {self.story()}")
        frame, wish = first.frame, first.frame.wish or ""
        if self._is_late(frame, wish):
            if result != self._late_result(wish):
                raise DivergenceError(f"a late copy of {wish} that waited is answered {result}", self.story())
            if result == REJECTED:
                self._tell_late(frame)
            return
        self._note(frame, refused=result != ACCEPTED)
        against = self._reason_against(wish)
        checked = wish in ("TRACK", ARMING) and not self._is_so(wish)
        if result != ACCEPTED:
            if not (against or (checked and (first.restless or self._flyable() is not True))):
                raise DivergenceError(f"{wish} is refused without a reason", self.story())
            return
        if against:
            raise DivergenceError(f"{wish} is accepted {against}", self.story())
        if checked and self._flyable() is False:
            raise DivergenceError(f"{wish} is accepted with an eight that cannot be flown")
        self._do(wish)

    def _flyable(self) -> bool | None:
        return can_be_flown(self._flight.parameters)

    # Parameters: a set is taken or refused as a whole

    def _set(self, frame: Frame) -> None:
        flight, message = self._flight, frame.message
        entry = load_parameters().get(message.param_id)
        value = float32(message.param_value)
        if entry is None or entry.read_only or entry.problem_with(value) or (entry.disarmed_only and flight.armed):
            if len(self._errors) < REFUSALS_ROOM:
                self._errors.append(message.param_id)
            if entry is not None:
                self._values.add(entry.name)
        elif entry.name in CURVE and (flight.mode == TRACK or self._checked.get(entry.name)):
            self._checked.setdefault(entry.name, []).append(value)
            self._unanswered.add(entry.name)
            self._since_checked = 0
        else:
            flight.parameters[entry.name] = value
            self._values.add(entry.name)
        if entry is not None and entry.name in CURVE:
            for waiting in self._waiting:
                waiting.restless = True

    def _settle_sets(self, seen: "Seen") -> None:
        flight = self._flight
        for name, values in self._checked.items():
            if seen.parameters[name] in values:
                flight.parameters[name] = seen.parameters[name]
        for answer in seen.of_kind("PARAM_VALUE"):
            self._settle_answer(answer.param_id, answer.param_value, seen.parameters[answer.param_id])
        for error in seen.of_kind("PARAM_ERROR"):
            if error.param_id in self._errors:
                self._errors.remove(error.param_id)
        if min(self._since_checked, self._since_question) >= PATIENCE_TICKS:
            self._end_checks()
        if not self._checked and seen.parameters != flight.parameters:
            wrong = {name: (value, seen.parameters[name]) for name, value in flight.parameters.items()
                     if seen.parameters[name] != value}
            raise DivergenceError("a parameter is not what was set", f"(page, firmware): {wrong}")
        if self._since_question >= PATIENCE_TICKS:
            if self._values:
                raise DivergenceError("a set is not answered with the value that holds", f"{self._values}")
            if self._errors:
                raise DivergenceError("a set is refused without PARAM_ERROR", f"{self._errors}")
        self._since_checked += 1
        self._since_question += 1

    def _settle_answer(self, name: str, told: float, held: float) -> None:
        """A PARAM_VALUE of what holds; one may answer several sets."""
        if told != held:
            raise DivergenceError("a set is answered with a value that does not hold", f"{name} {told}, not {held}")
        if name not in self._values and name not in self._checked:
            raise DivergenceError("a PARAM_VALUE that nobody asked for", name)
        self._unanswered.discard(name)
        if name in self._values:
            self._values.remove(name)
            return
        values = self._checked[name]  # taken, or refused and told what holds
        values.remove(told if told in values else values[0])
        if not values:
            del self._checked[name]

    def _end_checks(self) -> None:
        """All checks are through by now: what was not answered apart shared its answer with another set."""
        if self._unanswered:
            raise DivergenceError("a set that changes the eight is never answered", f"{self._unanswered}")
        self._checked.clear()
