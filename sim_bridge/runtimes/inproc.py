"""The firmware's own objects in this process: no sockets and no codec, but every field rounded as the wire does."""

from collections.abc import Sequence
from struct import Struct
from typing import Any, Final

from firmware_py.autopilot import Autopilot
from firmware_py.generated_enums import MAV_COMP_ID_AUTOPILOT1, MAV_COMP_ID_USER1
from firmware_py.mavlink.budget import LinkBudget
from firmware_py.mavlink.encoder import LONGEST_FRAME, Encoder
from firmware_py.mavlink.generated_messages import HEARTBEAT, HIL_ACTUATOR_CONTROLS, KITE_SENSORS, KITE_STATE, MESSAGES
from firmware_py.services.inbox import Inbox
from protocol.messages import BY_ID
from protocol.single_precision import float32
from sim_bridge.equipment.sensors import Sample
from sim_bridge.links.wire import BRIDGE_COMPONENT, BRIDGE_SYSTEM, Message, with_names
from sim_bridge.runtimes.interface import LEAD_IN_S
from sim_bridge.runtimes.tick_output import TickOutput, ToldState, clock_us

_STEERING: Final = 2  # place in HIL_ACTUATOR_CONTROLS
_AROUND: Final = 12  # bytes of a frame that are no payload
_LAYOUTS: Final = {message: Struct(layout) for message, (layout, *_) in MESSAGES.items()}


def as_on_the_wire(message: int, values: Sequence[Any]) -> tuple[Any, ...]:
    """`values` as they come out at the other end: floats in single precision, text padded with zeros."""
    layout = _LAYOUTS[message]
    return layout.unpack(layout.pack(*values))


class DirectLink:
    """The firmware's link without bytes: keeps what a tick sends, by kind; what nobody here looks at is dropped."""

    def __init__(self, keep_frames: bool):
        self.steering = 0.0
        self.state: ToldState | None = None
        self.mode: int | None = None
        self.replies: list[Message] = []
        self.frames: list[bytes] = []
        self.budget = LinkBudget(0)
        self._encoders = [Encoder(1, MAV_COMP_ID_AUTOPILOT1), Encoder(1, MAV_COMP_ID_USER1)] if keep_frames else []
        self.lockstep = True

    def set_system(self, system: int) -> None:
        """Send with this system id from now on."""
        for encoder in self._encoders:
            encoder.system = system

    def answer(self, message: int, values: Sequence[Any]) -> None:
        """Take an answer from the firmware."""
        self.budget.spend_on_answer(self.send(message, values) or _size(message, values))

    def send(self, message: int, values: Sequence[Any]) -> int:
        """Take a message from the firmware; return the bytes of its frame, where the firmware counts them."""
        if message == HIL_ACTUATOR_CONTROLS:
            self.steering = float32(values[_STEERING])
            return 0
        if self._encoders:
            buffer = bytearray(LONGEST_FRAME)
            end = self._encoders[message == KITE_STATE].encode(buffer, 0, message, values)
            self.frames.append(bytes(buffer[:end]))
        if message == KITE_STATE:
            self.state = _told(values)
        elif message == HEARTBEAT:
            self.mode, *_others = values
        elif message in BY_ID:
            self.replies.append((message, with_names(message, as_on_the_wire(message, values))))
            return _size(message, values)
        return 0

    def receive(self, inbox: Inbox, most: int = 0) -> int:
        """Nothing comes this way: `exchange` fills the inbox."""
        return 0

    def flush(self) -> None:
        """Nothing waits here."""

    def counters(self) -> tuple[int, int, int, int]:
        """There are no frames to lose."""
        return 0, 0, 0, 0


class InprocRuntime:
    """Runtime `inproc`. `keep_frames` also encodes what is sent, for a run log."""

    name = "inproc"
    lead_in_s = LEAD_IN_S

    def __init__(self, keep_frames: bool = False):
        self._link = DirectLink(keep_frames)
        self.autopilot = Autopilot(self._link, lockstep=True)

    def start(self) -> None:
        """Nothing to start."""

    def exchange(self, tick: int, time_s: float, samples: list[Sample], requests: list[Message],
                 datagrams: list[bytes]) -> TickOutput:
        """See Runtime; ground stations need a runtime with a wire."""
        link = self._link
        inbox = self.autopilot.inbox
        for sample in samples:
            inbox.put(KITE_SENSORS, sample, BRIDGE_SYSTEM, BRIDGE_COMPONENT)
        for message, values in requests:
            inbox.put(message, as_on_the_wire(message, values), BRIDGE_SYSTEM, BRIDGE_COMPONENT)
        self.autopilot.tick(clock_us(time_s))
        output = TickOutput()
        output.steering.append((time_s, link.steering))
        output.state = link.state
        output.mode = link.mode
        link.state = link.mode = None
        if link.replies:
            output.replies = link.replies
            link.replies = []
        if link.frames:
            output.frames = link.frames
            link.frames = []
        return output

    def stop(self) -> None:
        """Nothing to shut down."""


def _told(values: Any) -> ToldState:
    """What the bridge looks at of the `values` of a KITE_STATE."""
    (_time_us, sample_time_us, _azimuth, _elevation, _distance, course, _heading, _airspeed, _force, _steering,
     target_course, cross_track, path_parameter, steering_asked, overruns, _valid, status, _tick_us, _worst_us,
     _dropped, mode, _late_us) = values
    return ToldState(sample_time_us, float32(course), float32(target_course), float32(cross_track),
                     float32(path_parameter), float32(steering_asked), overruns, status, mode)


def _size(message: int, values: Sequence[Any]) -> int:
    """Bytes of a frame of `message`, whose zeros at the end are cut off."""
    return _AROUND + max(1, len(_LAYOUTS[message].pack(*values).rstrip(b"\0")))
