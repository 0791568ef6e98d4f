"""The interface between the bridge and the firmware, for all runtimes.

A runtime takes what the firmware may see in a tick and gives back what it made of it. Messages are (id, values in
wire order), as the firmware's own tables have them, so that no runtime needs to know more than that; those in
protocol/messages.py have names.
"""

from typing import NamedTuple, Protocol

from protocol.clock import WRAP_US
from protocol.messages import KiteState
from sim_bridge.equipment.sensors import Sample
from sim_bridge.links.wire import Message


class TickOutput(NamedTuple):
    """What came out of a tick.

    `steering` holds (time [s], steering) for each HIL_ACTUATOR_CONTROLS; `state` is the last KITE_STATE, None if there
    was none; `replies` are PARAM_VALUE, PARAM_ERROR, COMMAND_ACK and STATUSTEXT; `frames` are
    all frames for the ground path, as bytes; `mode` is the last HEARTBEAT's, None if there was none.
    """

    steering: list[tuple[float, float]]
    state: KiteState | None
    replies: list[Message]
    frames: list[bytes]
    mode: int | None = None


LEAD_IN_S = 2.0  # enough in lockstep, where nothing is lost


class Runtime(Protocol):
    """The firmware, running somewhere."""

    name: str
    lead_in_s: float  # before t = 0, for loading parameters and arming, beyond the delay of the control path

    def start(self) -> None:
        """Start the firmware.

        Raises:
            FirmwareError: it does not start.
        """
        ...

    def exchange(self, tick: int, time_s: float, samples: list[Sample], requests: list[Message],
                 datagrams: list[bytes]) -> TickOutput:
        """Run tick `tick` at `time_s` with the samples, the bridge's own requests, and what ground stations sent.

        Raises:
            FirmwareError: the firmware is silent or out of step.
        """
        ...

    def stop(self) -> None:
        """Shut the firmware down; safe to call twice."""
        ...


def clock_us(time_s: float) -> int:
    """The firmware's clock at `time_s` of the flight: it wraps 30 s after the start, so that every run crosses it."""
    return (round(time_s * 1e6) - 30_000_000) % WRAP_US
