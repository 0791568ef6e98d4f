"""Replays a recorded flight to a ground station with its timing, on a given clock and transport."""

from bisect import bisect_left

from ground.link.framing import FrameReader, Received
from ground.link.links import Clock
from ground.link.transports import Transport
from ground.logs.parameters import LoggedParameters
from ground.logs.reader import Heartbeat, Logged, MessageLog
from ground.replay.answers import ReplayAnswers
from ground.replay.numbering import Numbering
from protocol.frame import Address, read_header

_ANSWERS = {  # by id: answers to others, which the present ground station would take for its own
    4: "PING", 44: "MISSION_COUNT", 47: "MISSION_ACK", 77: "COMMAND_ACK", 110: "FILE_TRANSFER_PROTOCOL",
    111: "TIMESYNC", 345: "PARAM_ERROR"}
_BEAT_S = 1.2  # the longest time between heartbeats in a pause or at low speed; ground stations give up after 3 s
_AT_ONCE = 100
SLOWEST, FASTEST = 1 / 64, 1024.0


class Replay:
    """Sends what the vehicles of `log` sent from `from_s` to `to_s` [s], `speed` times as fast, and answers requests.

    Recorded answers to others, and frames of ground stations, are omitted. Everything happens in `poll`.
    """

    def __init__(self, log: MessageLog, transport: Transport, clock: Clock, speed: float = 1.0, from_s: float = 0.0,
                 to_s: float | None = None, loop: bool = False) -> None:
        self.from_s, self.to_s = from_s, log.duration_s if to_s is None else min(to_s, log.duration_s)
        self.loop = loop
        self.sent = self.answered = self.bytes_received = self.laps = 0
        self.beat: Heartbeat | None = None  # the last heartbeat sent
        self.over = False
        self._answers = {vehicle: ReplayAnswers(log, vehicle, LoggedParameters(log, vehicle))
                         for vehicle in log.vehicles}
        self._entries = [self._answers[entry.sender].rewritten(entry) if entry.sender in self._answers else entry
                         for entry in log.messages if entry.sender not in log.stations]
        self._beats: dict[Address, tuple[float, bytes]] = {}
        self._numbering = {entry.sender: Numbering() for entry in self._entries}
        self._transport, self._clock, self._reader = transport, clock, FrameReader()
        self._speed, self._paused = speed, False
        self._start_lap()

    @property
    def position_s(self) -> float:
        """Position in the log [s]."""
        elapsed_s = 0.0 if self._paused else (self._clock() - self._anchor_clock_s) * self._speed
        return min(self._anchor_s + elapsed_s, self.to_s)

    @property
    def paused(self) -> bool:
        """Whether the replay is paused; heartbeats continue."""
        return self._paused

    @paused.setter
    def paused(self, paused: bool) -> None:
        self._anchor()
        self._paused = paused

    @property
    def speed(self) -> float:
        """Speed, relative to that of the flight."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        self._anchor()
        self._speed = min(max(speed, SLOWEST), FASTEST)

    def poll(self, timeout_s: float) -> bool:
        """Send what is due, wait up to `timeout_s` [s] for requests, and answer them; return whether it goes on.

        Raises:
            LinkError: the link is broken.
        """
        self._send_due()
        self._keep_beating()
        if self.over:
            return False
        data = self._transport.receive(max(min(timeout_s, self._until_next_s()), 0.0))
        self.bytes_received += len(data)
        for received in self._reader.feed(data):
            self._answer(received)
        return True

    def _start_lap(self) -> None:
        self._next = bisect_left(self._entries, self.from_s, key=lambda entry: entry.time_s)
        self._anchor_s, self._anchor_clock_s = self.from_s, self._clock()
        for numbering in self._numbering.values():
            numbering.start_over()

    def _anchor(self) -> None:
        self._anchor_s, self._anchor_clock_s = self.position_s, self._clock()

    def _send_due(self) -> None:
        position_s = self.position_s
        for _ in range(_AT_ONCE):
            entry = self._upcoming()
            if entry is None:
                if position_s >= self.to_s:
                    self._end_lap()
                return
            if entry.time_s > position_s:
                return
            self._next += 1
            if entry.header.message in _ANSWERS:
                self._numbering[entry.sender].left_out()
                continue
            self._transport.send(self._numbering[entry.sender].recorded(entry.frame))
            self.sent += 1
            if isinstance(entry.message, Heartbeat):
                self.beat = entry.message
                self._beats[entry.sender] = (self._clock(), entry.frame)

    def _upcoming(self) -> Logged | None:
        """The next entry to send, or None at the end of this lap."""
        entry = self._entries[self._next] if self._next < len(self._entries) else None
        return entry if entry is not None and entry.time_s <= self.to_s else None

    def _end_lap(self) -> None:
        self.laps += 1
        self.over = not self.loop
        if self.loop:
            self._start_lap()

    def _until_next_s(self) -> float:
        """Time until the next entry or heartbeat is due [s]."""
        if self._paused:
            return _BEAT_S
        entry = self._upcoming()
        due_s = self.to_s if entry is None else entry.time_s
        return min((due_s - self.position_s) / self._speed, _BEAT_S)

    def _keep_beating(self) -> None:
        """Repeat heartbeats if the replay, not the recorded link, is the reason why none is due."""
        if not self._paused and self._speed >= 1.0:
            return
        for address, (sent_s, frame) in list(self._beats.items()):
            if self._clock() - sent_s >= _BEAT_S:
                self._transport.send(self._numbering[address].added(frame))
                self._beats[address] = (self._clock(), frame)

    def _answer(self, request: Received) -> None:
        for vehicle, answers in self._answers.items():
            frames = answers.answer(request, self.position_s)
            self.answered += bool(frames)
            for frame in frames:
                numbering = self._numbering.get(read_header(frame).sender) or self._numbering[vehicle]
                self._transport.send(numbering.added(frame))
