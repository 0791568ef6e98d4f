"""What came out of a tick of the firmware, and the firmware's clock."""

from typing import Final

from protocol.clock import WRAP_US
from protocol.messages import KiteState
from sim_bridge.links.wire import Message

_START_US: Final = 30_000_000  # before the wrap


class ToldState:
    """What the bridge looks at of a KITE_STATE; the names are that message's."""

    def __init__(self, sample_time_us: int, course: float, target_course: float, cross_track: float,
                 path_parameter: float, steering_asked: float, overruns: int, status: int, mode: int) -> None:
        self.sample_time_us = sample_time_us
        self.course = course
        self.target_course = target_course
        self.cross_track = cross_track
        self.path_parameter = path_parameter
        self.steering_asked = steering_asked
        self.overruns = overruns
        self.status = status
        self.mode = mode


def told_state(state: KiteState) -> ToldState:
    """What the bridge looks at of `state`."""
    return ToldState(state.sample_time_us, state.course, state.target_course, state.cross_track, state.path_parameter,
                     state.steering_asked, state.overruns, state.status, state.mode)


class TickOutput:
    """What came out of a tick.

    `steering` holds (time [s], steering) for each HIL_ACTUATOR_CONTROLS; `state` is of the last KITE_STATE, None if
    there was none; `replies` are PARAM_VALUE, PARAM_ERROR, COMMAND_ACK and STATUSTEXT; `frames` are all frames for the
    ground path, as bytes; `mode` is the last HEARTBEAT's, None if there was none.
    """

    def __init__(self) -> None:
        self.steering: list[tuple[float, float]] = []
        self.state: ToldState | None = None
        self.replies: list[Message] = []
        self.frames: list[bytes] = []
        self.mode: int | None = None


def clock_us(time_s: float) -> int:
    """The firmware's clock at `time_s` of the flight: it wraps 30 s after the start, so that every run crosses it."""
    return (round(time_s * 1e6) - _START_US) % WRAP_US
