"""A MAVLink conversation with one vehicle over one or several links, on a given clock."""

from collections.abc import Callable
from typing import NamedTuple

from ground.link.duplicates import FirstCopies
from ground.link.framing import Message
from ground.link.links import Clock, Heard, Links
from ground.link.round_trip import Question, RoundTrip
from ground.link.statistics import LinkStatistics
from protocol import dialect
from protocol.frame import Address

Observer = Callable[[float, Message, bytes], None]

GROUND_SYSTEM = 255
GROUND_COMPONENT = dialect.MAV_COMP_ID_MISSIONPLANNER
KITE_COMPONENT = dialect.MAV_COMP_ID_USER1  # sends KITE_STATE (with older firmware, the autopilot does)
HEARTBEAT_PERIOD_S = 1.0
SILENCE_S = 10.0  # without any message for this long, the link is down
_MOST_TIMINGS = 512
_FRAMES_PER_SECOND = 40  # more than a station sends on average
_QUICK, _SLOW_S = 4, 0.8  # this many attempts at the pace of the link, later ones at least this far apart
_OVERTAKEN = 10  # by more messages than jitter explains: it came over a slower link
_PRESENT = (  # messages that report a present state: one overtaken that far reports a past one
    dialect.MAVLink_heartbeat_message, dialect.MAVLink_kite_state_message, dialect.MAVLink_sys_status_message,
    dialect.MAVLink_local_position_ned_message, dialect.MAVLink_param_value_message)


def is_of(sender: Address, vehicle: Address | None) -> bool:
    """Whether `sender` is the vehicle: its autopilot, or the component of its system that sends KITE_STATE.

    The latter has its own id, since ground stations that do not know KITE_STATE would otherwise count losses.
    """
    return vehicle is not None and sender in (vehicle, Address(vehicle.system, KITE_COMPONENT))


class VehicleClock(NamedTuple):
    """How long the vehicle had been running [s] when our clock showed `heard_s` [s]."""

    uptime_s: float
    heard_s: float


class _Observing(NamedTuple):
    """An observer of the vehicle's messages, or of everyone's."""

    observer: Observer
    everyone: bool


class Connection:
    """Sends and receives messages, sends heartbeats, and measures the quality of the links.

    Everything happens inside `poll` and the two `wait` functions, which wait only in `links.receive`. The vehicle is
    the first autopilot whose heartbeat is heard (of system `vehicle_system`, if given); until then, requests go to
    system 1, component 1. A frame that arrives over several links counts once.
    """

    def __init__(self, links: Links, vehicle_system: int | None = None) -> None:
        self.links = links
        self.clock: Clock = links.clock
        self.vehicle: Address | None = None
        self.others: set[int] = set()  # systems of other autopilots
        self.statistics = LinkStatistics()
        self.round_trip = RoundTrip()
        self.timing_period_s = HEARTBEAT_PERIOD_S  # how often the round trip is timed
        self.vehicle_clock: VehicleClock | None = None
        self.every_second: list[Callable[[], None]] = []
        self._vehicle_system = vehicle_system
        self._renamed: int | None = None
        self._encoder = dialect.MAVLink(None, GROUND_SYSTEM, GROUND_COMPONENT)
        # The vehicle recognizes late commands by their sequence numbers: those of this process must follow those of the
        # one before it.
        self._encoder.seq = int(self.clock() * _FRAMES_PER_SECOND) % 256
        self._first_copies = FirstCopies()
        self._observers: list[_Observing] = []
        self._next_heartbeat_s = self._next_timing_s = self.clock()
        self._timings: dict[int, Question] = {}  # TIMESYNC requests under way

    @property
    def target(self) -> Address:
        """Where requests are sent."""
        return self.vehicle or Address(self._vehicle_system or 1, dialect.MAV_COMP_ID_AUTOPILOT1)

    def add_observer(self, observer: Observer, everyone: bool = False) -> None:
        """Call `observer(time_s, message, frame)` for the vehicle's messages, or for `everyone`'s and unknown ones."""
        self._observers.append(_Observing(observer, everyone))

    def remove_observer(self, observer: Observer) -> None:
        """Undo `add_observer`."""
        self._observers = [entry for entry in self._observers if entry.observer != observer]

    def send(self, message: Message, everywhere: bool = False) -> None:
        """Send a message over the links on which the vehicle is heard, or `everywhere`."""
        self.links.send(message.pack(self._encoder), everywhere)
        self._encoder.seq = (self._encoder.seq + 1) % 256

    def expect_renamed(self, system: int | None) -> None:
        """Follow the vehicle to its new id `system` once that is heard. None: it keeps its id."""
        self._renamed = system

    def poll(self, timeout_s: float) -> list[Message]:
        """Send what is due, wait up to `timeout_s` [s] for bytes, and return the vehicle's new messages."""
        now_s = self.clock()
        if now_s >= self._next_heartbeat_s:
            self._next_heartbeat_s = now_s + HEARTBEAT_PERIOD_S
            self._speak_up()
        if self.vehicle and now_s >= self._next_timing_s:
            self._next_timing_s = now_s + self.timing_period_s
            self._ask_the_time(now_s)
        due_s = min(self._next_heartbeat_s, self._next_timing_s if self.vehicle else self._next_heartbeat_s)
        return [heard.received.message for heard in self.links.receive(max(min(timeout_s, due_s - now_s), 0.0))
                if self._take(heard)]

    def wait_for(self, predicate: Callable[[Message], bool], timeout_s: float) -> Message | None:
        """The vehicle's first message that `predicate` accepts, or None after `timeout_s` [s]."""
        end_s = self.clock() + timeout_s
        while (left_s := end_s - self.clock()) > 0.0:
            for message in self.poll(left_s):
                if predicate(message):
                    return message
        return None

    def wait_until(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Wait up to `timeout_s` [s] until `condition`, which observers change, is true; return whether it is."""
        end_s = self.clock() + timeout_s
        while not condition():
            left_s = end_s - self.clock()
            if left_s <= 0.0:
                return False
            self.poll(left_s)
        return True

    def silence_s(self, since_s: float) -> float:
        """How long the vehicle has been silent, counted from `since_s` on the clock at the earliest [s]."""
        return self.clock() - max(since_s, self.statistics.last_s or since_s)

    def patience_s(self, attempt: int) -> float:
        """How long to wait for an answer to this attempt, counted from 0, before the next one [s].

        Longer after a few attempts, to survive a short outage and not to fill a full link further.
        """
        wait_s = self.round_trip.timeout_s
        return wait_s if attempt < _QUICK else max(wait_s, _SLOW_S)

    def why_silent(self, since_s: float) -> str:
        """Why there is no answer, for a message: the time waited since `since_s`, the cause if known, what to try."""
        tried = f"no answer in {self.clock() - since_s:.0f} s"
        if self.silence_s(since_s) < SILENCE_S:
            return (f"{tried}, though the kite is heard: nothing sent reaches it; "
                    "move closer to it, or use another --link")
        if problems := [link.problem for link in self.links.all if link.problem]:
            return f"{tried}: the link is down ({'; '.join(problems)})"
        return (f"{tried}, and nothing else from the kite: the link is down; "
                "check the kite's power, the radio and the cable, and try again")

    def close(self) -> None:
        """Close the links."""
        self.links.close()

    def _speak_up(self) -> None:
        self.send(dialect.MAVLink_heartbeat_message(
            dialect.MAV_TYPE_GCS, dialect.MAV_AUTOPILOT_INVALID, 0, 0, dialect.MAV_STATE_ACTIVE, 3), everywhere=True)
        for action in self.every_second:
            action()

    def _ask_the_time(self, now_s: float) -> None:
        stamp = int(now_s * 1e9) + 1
        self._timings[stamp] = self.round_trip.ask(now_s)
        if len(self._timings) > _MOST_TIMINGS:
            del self._timings[next(iter(self._timings))]
        self.send(dialect.MAVLink_timesync_message(0, stamp))

    def _take(self, heard: Heard) -> bool:
        """Pass a message on to the observers; return whether it is the vehicle's, and new."""
        time_s, received = self.clock(), heard.received
        message, header, sender = received.message, received.header, received.header.sender
        if isinstance(message, dialect.MAVLink_heartbeat_message):
            self._meet(message, sender)
        from_vehicle = is_of(sender, self.vehicle)
        if from_vehicle:
            heard.link.statistics.add(time_s, header.sequence, sender.component)
            if isinstance(message, dialect.MAVLink_heartbeat_message):
                heard.link.meet(time_s)
        if not self._first_copies.is_first(sender, received.frame):
            return False
        known = not isinstance(message, dialect.MAVLink_unknown)
        overtaken = self.statistics.add(time_s, header.sequence, sender.component) if from_vehicle else 0
        news = from_vehicle and known and (overtaken < _OVERTAKEN or not isinstance(message, _PRESENT))
        if from_vehicle and isinstance(message, dialect.MAVLink_timesync_message):
            self._time(message, time_s)
        for observer, everyone in list(self._observers):
            if everyone or news:
                observer(time_s, message, received.frame)
        return news

    def _meet(self, heartbeat: dialect.MAVLink_heartbeat_message, sender: Address) -> None:
        if heartbeat.type == dialect.MAV_TYPE_GCS or heartbeat.autopilot == dialect.MAV_AUTOPILOT_INVALID:
            return
        if self.vehicle and self._renamed == sender.system:
            self.vehicle, self._vehicle_system, self._renamed = sender, sender.system, None
        elif self._vehicle_system not in (None, sender.system) or self.vehicle not in (None, sender):
            self.others.add(sender.system)
        elif self.vehicle is None:
            self.vehicle = sender
            self._next_heartbeat_s = self.clock()  # send a heartbeat and time the first answer at once

    def _time(self, answer: dialect.MAVLink_timesync_message, time_s: float) -> None:
        if answer.tc1 and (question := self._timings.pop(answer.ts1, None)) is not None:
            self.round_trip.answer(question, time_s)
            self.vehicle_clock = VehicleClock(answer.tc1 * 1e-9, time_s)
