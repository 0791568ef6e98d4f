"""The interface between the bridge and the firmware, for all runtimes.

A runtime takes what the firmware may see in a tick and gives back what it made of it. Messages are (id, values in
wire order), as the firmware's own tables have them, so that no runtime needs to know more than that; those in
protocol/messages.py have names.
"""

from typing import Final, Protocol

from sim_bridge.equipment.sensors import Sample
from sim_bridge.links.wire import Message
from sim_bridge.runtimes.tick_output import TickOutput

LEAD_IN_S: Final = 2.0  # enough in lockstep, where nothing is lost


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
