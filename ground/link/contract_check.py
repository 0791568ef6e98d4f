"""Asks the vehicle which contract it was built with, and warns if it is not this ground station's."""

from collections.abc import Callable

from ground.link.connection import Connection
from ground.link.framing import Message
from protocol import dialect
from protocol.contract import CONTRACT_HASH

ATTEMPTS = 6


class ContractCheck:
    """Requests AUTOPILOT_VERSION once a second while the connection is served, ATTEMPTS times at most.

    `warn` is called once, with one line, if the vehicle's contract differs.
    """

    def __init__(self, connection: Connection, warn: Callable[[str], None]) -> None:
        self.known = False
        self._connection = connection
        self._warn = warn
        self._left = ATTEMPTS
        connection.add_observer(self._observe)
        connection.every_second.append(self._ask)

    def wait(self, timeout_s: float) -> bool:
        """Wait up to `timeout_s` [s] for the vehicle's contract; return whether it is known."""
        return self._connection.wait_until(lambda: self.known, timeout_s)

    def _ask(self) -> None:
        if self.known or self._left <= 0 or self._connection.vehicle is None:
            return
        self._left -= 1
        system, component = self._connection.target
        self._connection.send(dialect.MAVLink_command_long_message(
            system, component, dialect.MAV_CMD_REQUEST_MESSAGE, 0,
            float(dialect.MAVLINK_MSG_ID_AUTOPILOT_VERSION), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))

    def _observe(self, time_s: float, message: Message, frame: bytes) -> None:
        if self.known or not isinstance(message, dialect.MAVLink_autopilot_version_message):
            return
        self.known = True
        theirs = bytes(message.middleware_custom_version).hex()
        if theirs != CONTRACT_HASH:
            self._warn(f"warning: the kite was built with contract {theirs}, this ground station with "
                       f"{CONTRACT_HASH}: names, limits and units may differ; use the same version on both sides")
