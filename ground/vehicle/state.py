"""The vehicle's state, from its latest messages."""

from dataclasses import dataclass
from typing import NamedTuple

from ground.link.framing import Message
from protocol import dialect
from protocol.modes import mode_name

SEVERITY_NAMES = {
    value: entry.name.removeprefix("MAV_SEVERITY_").lower() for value, entry in dialect.enums["MAV_SEVERITY"].items()
}


_KEPT_TEXTS = 100


class StatusText(NamedTuple):
    """A line of text from the vehicle: its arrival on the ground's clock [s], and its severity (0 worst, to 7)."""

    time_s: float
    severity: int
    text: str

    @property
    def severity_name(self) -> str:
        return SEVERITY_NAMES.get(self.severity, str(self.severity))


@dataclass
class VehicleState:
    """The latest message of each kind; None before the first. Times are on the ground's clock [s]."""

    mode: int | None = None
    armed: bool | None = None
    kite: dialect.MAVLink_kite_state_message | None = None
    system: dialect.MAVLink_sys_status_message | None = None
    position: dialect.MAVLink_local_position_ned_message | None = None
    texts: tuple[StatusText, ...] = ()  # oldest first; never changed in place, as another thread may read it

    @property
    def mode_name(self) -> str:
        return "unknown" if self.mode is None else mode_name(self.mode)

    def observe(self, time_s: float, message: Message, frame: bytes) -> None:
        """Keep one of the vehicle's messages, as an observer of a connection."""
        if isinstance(message, dialect.MAVLink_kite_state_message):
            self.kite = message
        elif isinstance(message, dialect.MAVLink_heartbeat_message):
            self.mode, self.armed = message.custom_mode, is_armed(message)
        elif isinstance(message, dialect.MAVLink_sys_status_message):
            self.system = message
        elif isinstance(message, dialect.MAVLink_local_position_ned_message):
            self.position = message
        elif isinstance(message, dialect.MAVLink_statustext_message):
            text = StatusText(time_s, message.severity, message.text)
            self.texts = (*self.texts, text)[-_KEPT_TEXTS:]


def is_armed(heartbeat: dialect.MAVLink_heartbeat_message) -> bool:
    """Whether this heartbeat's vehicle is armed."""
    return bool(heartbeat.base_mode & dialect.MAV_MODE_FLAG_SAFETY_ARMED)
