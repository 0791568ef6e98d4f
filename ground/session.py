"""A ground station at work: one connection, and everything that listens to it or speaks over it."""

from collections.abc import Callable
from types import TracebackType

from ground.commands import Commander
from ground.connection import Clock, Connection
from ground.contract_check import ContractCheck
from ground.errors import UsageError
from ground.parameter_client import ParameterClient
from ground.transport import Transport
from ground.vehicle_state import VehicleState

_ADVICE = {
    "udpin": "is the vehicle running, and does it send to this address and port?",
    "udpout": "is the vehicle running, and does it listen on this address and port?",
    "serial": "is the board powered, is this its port, and is the baud rate right?",
}


class Session:
    """Owns the transport and closes it. `link` is how the user named it; `warn` takes one-line warnings."""

    def __init__(self, transport: Transport, clock: Clock, link: str, warn: Callable[[str], None],
                 vehicle_system: int | None = None) -> None:
        self.link = link
        self.connection = Connection(transport, clock, vehicle_system)
        self.state = VehicleState()
        self.connection.add_observer(self.state.observe)
        self.contract = ContractCheck(self.connection, warn)
        self.parameters = ParameterClient(self.connection)
        self.commander = Commander(self.connection)
        self._vehicle_system = vehicle_system

    def find_vehicle(self, timeout_s: float) -> None:
        """Wait for the vehicle's heartbeat. Raises UsageError, with what to check, when none comes."""
        if self.connection.wait_until(lambda: self.connection.vehicle is not None, timeout_s):
            return
        nothing = f"no heartbeat within {timeout_s:g} s on {self.link}"
        if others := sorted(self.connection.others):
            heard = ", ".join(map(str, others))
            raise UsageError(f"{nothing} from system {self._vehicle_system}: heard system {heard}; check --system")
        if self.connection.bytes_received:
            raise UsageError(f"{nothing}, though {self.connection.bytes_received} bytes came: "
                             "is that MAVLink, from a vehicle, and at the right baud rate?")
        raise UsageError(f"{nothing}: {_ADVICE.get(self.link.partition(':')[0], 'is the vehicle running?')}")

    def check_contract(self) -> None:
        """Give the vehicle a few seconds to say which contract it has: what follows depends on the table."""
        self.contract.wait(4.0)

    def __enter__(self) -> "Session":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.connection.close()
