"""A running ground station: one connection, and everything that listens or sends on it."""

from collections import deque
from collections.abc import Callable
from types import TracebackType

from ground.errors import UsageError
from ground.link.connection import Connection
from ground.link.contract_check import ContractCheck
from ground.link.links import Links
from ground.parameters.client import ParameterClient
from ground.vehicle.commands import Commander
from ground.vehicle.state import VehicleState

_ADVICE = {
    "udpin": "is the kite running, and does it send to this address and port?",
    "udpout": "is the kite running, and does it listen on this address and port?",
    "serial": "is the board powered, is this its port, and is the baud rate right?",
}
_CONTRACT_S = 8.0


class Session:
    """Owns the links and closes them. One-line warnings go to `on_notice` and are kept in `notices`."""

    def __init__(self, links: Links, on_notice: Callable[[str], None], vehicle_system: int | None = None) -> None:
        self.links = links
        self.on_notice = on_notice
        self.notices: deque[tuple[float, str]] = deque(maxlen=20)  # with the time on the connection's clock [s]
        links.warn = self.notice
        self.connection = Connection(links, vehicle_system)
        self.state = VehicleState()
        self.connection.add_observer(self.state.observe)
        self.contract = ContractCheck(self.connection, self.notice)
        self.parameters = ParameterClient(self.connection)
        self.commander = Commander(self.connection)
        self._vehicle_system = vehicle_system

    def notice(self, text: str) -> None:
        """Show the user a line."""
        self.notices.append((self.connection.clock(), text))
        self.on_notice(text)

    def find_vehicle(self, timeout_s: float) -> None:
        """Wait for the vehicle's heartbeat. Raises UsageError, with advice on what to check, if none arrives."""
        if self.connection.wait_until(lambda: self.connection.vehicle is not None, timeout_s):
            return
        nothing = f"no heartbeat within {timeout_s:g} s on {self.links.name}"
        if others := sorted(self.connection.others):
            heard = ", ".join(map(str, others))
            raise UsageError(f"{nothing} from system {self._vehicle_system}: heard system {heard}; check --system")
        if count := sum(link.bytes_received for link in self.links.all):
            raise UsageError(f"{nothing}, though {count} bytes came: "
                             "is that MAVLink, from a kite, and is the baud rate right?")
        kinds = {link.name.partition(":")[0] for link in self.links.all}
        advice = _ADVICE.get(kinds.pop(), "") if len(kinds) == 1 else ""
        raise UsageError(f"{nothing}: {advice or 'is the kite running, and are these its links?'}")

    def check_contract(self) -> None:
        """Give the vehicle a few seconds to report its contract: later requests depend on the parameter table.

        By then the round trip has been measured too, so that later requests are not repeated too soon.
        """
        started_s = self.connection.clock()
        known = self.contract.wait(_CONTRACT_S)
        self.connection.wait_until(lambda: self.connection.round_trip.seconds is not None,
                                   _CONTRACT_S - (self.connection.clock() - started_s))
        if not known:
            self.notice(f"warning: the kite did not report its contract within {_CONTRACT_S:g} s: "
                        "names, limits and units are those of this ground station")

    def __enter__(self) -> "Session":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.links.close()
