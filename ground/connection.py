"""A MAVLink conversation with one vehicle over a transport, on a clock that is handed in."""

from collections.abc import Callable
from typing import NamedTuple

from ground.framing import FrameReader, Message, Received
from ground.link_statistics import LinkStatistics, RoundTrip
from ground.transport import Transport
from protocol import dialect

Clock = Callable[[], float]
Observer = Callable[[float, Message, bytes], None]

GROUND_SYSTEM = 255
GROUND_COMPONENT = dialect.MAV_COMP_ID_MISSIONPLANNER
HEARTBEAT_PERIOD_S = 1.0


class Address(NamedTuple):
    """Who on the MAVLink network: system and component id."""

    system: int
    component: int


class Connection:
    """Sends and receives messages, beats its heart, and keeps count of how well the link does.

    Everything happens inside `poll` and the two `wait` functions, which wait in `transport.receive` only; `clock`
    gives seconds. The vehicle is the first autopilot whose heartbeat is heard (`vehicle_system` narrows it down);
    until then requests go to system 1, component 1.
    """

    def __init__(self, transport: Transport, clock: Clock, vehicle_system: int | None = None) -> None:
        self.clock = clock
        self.vehicle: Address | None = None
        self.others: set[int] = set()  # systems that are autopilots too, but not the one wanted
        self.statistics = LinkStatistics()
        self.round_trip = RoundTrip()
        self.bytes_received = 0
        self.every_second: list[Callable[[], None]] = []
        self._transport = transport
        self._vehicle_system = vehicle_system
        self._encoder = dialect.MAVLink(None, GROUND_SYSTEM, GROUND_COMPONENT)
        self._reader = FrameReader()
        self._observers: list[tuple[Observer, bool]] = []
        self._next_heartbeat_s = clock()
        self._timings: dict[int, float] = {}  # TIMESYNC on its way, and when it was sent

    @property
    def target(self) -> Address:
        """Whom requests go to."""
        return self.vehicle or Address(self._vehicle_system or 1, dialect.MAV_COMP_ID_AUTOPILOT1)

    def add_observer(self, observer: Observer, everyone: bool = False) -> None:
        """Call `observer(time_s, message, frame)` for the vehicle's messages, or for `everyone`'s and unknown ones."""
        self._observers.append((observer, everyone))

    def remove_observer(self, observer: Observer) -> None:
        """Take back `add_observer`."""
        self._observers = [entry for entry in self._observers if entry[0] != observer]

    def send(self, message: Message) -> None:
        """Send one message. Raises LinkError when the link is broken."""
        self._transport.send(message.pack(self._encoder))
        self._encoder.seq = (self._encoder.seq + 1) % 256

    def poll(self, timeout_s: float) -> list[Message]:
        """Wait up to `timeout_s` [s] for bytes, see to what is due, and return the vehicle's messages that came."""
        now_s = self.clock()
        if now_s >= self._next_heartbeat_s:
            self._next_heartbeat_s = now_s + HEARTBEAT_PERIOD_S
            self._speak_up(now_s)
        data = self._transport.receive(max(min(timeout_s, self._next_heartbeat_s - now_s), 0.0))
        self.bytes_received += len(data)
        return [received.message for received in self._reader.feed(data) if self._take(received)]

    def wait_for(self, predicate: Callable[[Message], bool], timeout_s: float) -> Message | None:
        """The vehicle's first message that `predicate` accepts, or None after `timeout_s` [s]."""
        end_s = self.clock() + timeout_s
        while (left_s := end_s - self.clock()) > 0.0:
            for message in self.poll(left_s):
                if predicate(message):
                    return message
        return None

    def wait_until(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Whether `condition` (which observers change) came true within `timeout_s` [s]."""
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

    def close(self) -> None:
        """Close the transport."""
        self._transport.close()

    def _speak_up(self, now_s: float) -> None:
        self.send(dialect.MAVLink_heartbeat_message(
            dialect.MAV_TYPE_GCS, dialect.MAV_AUTOPILOT_INVALID, 0, 0, dialect.MAV_STATE_ACTIVE, 3))
        if self.vehicle:
            stamp = int(now_s * 1e9) + 1
            self._timings = {old: sent_s for old, sent_s in self._timings.items() if now_s - sent_s < 30.0}
            self._timings[stamp] = now_s
            self.send(dialect.MAVLink_timesync_message(0, stamp))
        for action in self.every_second:
            action()

    def _take(self, received: Received) -> bool:
        """Pass a message on to whom it concerns; whether it is the vehicle's."""
        time_s = self.clock()
        message, sender = received.message, Address(received.system, received.component)
        if isinstance(message, dialect.MAVLink_heartbeat_message):
            self._meet(message, sender)
        known = not isinstance(message, dialect.MAVLink_unknown)
        from_vehicle = sender == self.vehicle
        if from_vehicle:
            self.statistics.add(time_s, received.sequence)
        if from_vehicle and isinstance(message, dialect.MAVLink_timesync_message):
            self._time(message, time_s)
        for observer, everyone in list(self._observers):
            if everyone or (from_vehicle and known):
                observer(time_s, message, received.frame)
        return from_vehicle and known

    def _meet(self, heartbeat: dialect.MAVLink_heartbeat_message, sender: Address) -> None:
        if heartbeat.type == dialect.MAV_TYPE_GCS or heartbeat.autopilot == dialect.MAV_AUTOPILOT_INVALID:
            return
        if self._vehicle_system not in (None, sender.system) or self.vehicle not in (None, sender):
            self.others.add(sender.system)
        elif self.vehicle is None:
            self.vehicle = sender
            self._next_heartbeat_s = self.clock()  # say hello, and time the first answer, at once

    def _time(self, answer: dialect.MAVLink_timesync_message, time_s: float) -> None:
        if answer.tc1 and (sent_s := self._timings.pop(answer.ts1, None)) is not None:
            self.round_trip.add(time_s - sent_s)
