"""The firmware with its codec in this process: bytes, but no sockets and no wall clock.

For ground stations in simulated time: what they send reaches the real parser, and the flight waits for them.
"""

from firmware_py.autopilot import Autopilot
from firmware_py.loop import step_lockstep
from firmware_py.mavlink.link import MavlinkLink
from sim_bridge.errors import FirmwareError
from sim_bridge.runtimes.wired import WireRuntime


class _Transport:
    """The firmware's end: datagrams in two lists."""

    datagrams = True

    def __init__(self) -> None:
        self.to_firmware: list[bytes] = []
        self.from_firmware: list[bytes] = []

    def read(self) -> bytes | None:
        """One datagram, or None."""
        return self.to_firmware.pop(0) if self.to_firmware else None

    def write(self, data: memoryview) -> None:
        """Send a datagram."""
        self.from_firmware.append(bytes(data))


class MemoryRuntime(WireRuntime):
    """Runtime `memory`."""

    name = "memory"

    def __init__(self) -> None:
        super().__init__()
        self._transport = _Transport()
        self.autopilot = Autopilot(MavlinkLink(self._transport), lockstep=True)

    def start(self) -> None:
        """Nothing to start."""

    def stop(self) -> None:
        """Nothing to shut down."""

    def _send(self, datagram: bytes) -> None:
        self._transport.to_firmware.append(datagram)

    def _receive(self, deadline: float, when: str) -> bytes:
        while self._transport.to_firmware and not self._transport.from_firmware:
            step_lockstep(self.autopilot, self.autopilot.inbox)
        if not self._transport.from_firmware:
            raise FirmwareError(f"the firmware is silent {when}")
        return self._transport.from_firmware.pop(0)
