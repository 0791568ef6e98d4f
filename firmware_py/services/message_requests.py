"""Messages on request, once or periodically: REQUEST_MESSAGE and message intervals."""

from ..generated_enums import (
    KITE_MODE_MANUAL,
    KITE_MODE_STANDBY,
    MAV_MODE_PROPERTY_ADVANCED,
    MAV_MODE_PROPERTY_NOT_USER_SELECTABLE,
    MAV_PROTOCOL_CAPABILITY_COMMAND_INT,
    MAV_PROTOCOL_CAPABILITY_FTP,
    MAV_PROTOCOL_CAPABILITY_MAVLINK2,
    MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST,
    MAV_RESULT_ACCEPTED,
    MAV_RESULT_DENIED,
    MAV_RESULT_TEMPORARILY_REJECTED,
    MAV_RESULT_UNSUPPORTED,
)
from ..mavlink.generated_messages import (
    AUTOPILOT_VERSION,
    AVAILABLE_MODES,
    AVAILABLE_MODES_MONITOR,
    COMPONENT_METADATA,
    CONTRACT_HASH,
    CURRENT_MODE,
    MESSAGE_INTERVAL,
    MESSAGES,
)
from ..modes.mode_machine import NAMES
from .generated_metadata import CRC32S, GENERAL, GENERAL_URI

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

    from ..mavlink.interface import Link
    from .telemetry import Telemetry

FIRMWARE_VERSION = (0, 1, 0)  # type: Final[tuple[int, ...]]
_CAPABILITIES = (
    MAV_PROTOCOL_CAPABILITY_MAVLINK2
    | MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST
    | MAV_PROTOCOL_CAPABILITY_FTP
    | MAV_PROTOCOL_CAPABILITY_COMMAND_INT
)  # type: Final
_PROPERTIES = {
    KITE_MODE_STANDBY: MAV_MODE_PROPERTY_NOT_USER_SELECTABLE,  # one disarms for that
    KITE_MODE_MANUAL: MAV_MODE_PROPERTY_ADVANCED,
}  # type: Final[dict[int, int]]
_OWN = (AUTOPILOT_VERSION, AVAILABLE_MODES, AVAILABLE_MODES_MONITOR, COMPONENT_METADATA)  # type: Final[tuple[int, ...]]
_ABOUT_MODES = (AVAILABLE_MODES, AVAILABLE_MODES_MONITOR, CURRENT_MODE)  # type: Final[tuple[int, ...]]
_AROUND = 12  # type: Final  # bytes of a frame that are no payload
_LAST_ID = 16777215.0  # type: Final
_SHORTEST_US = 5000.0  # type: Final
_LONGEST_US = 500000000.0  # type: Final  # must be less than half the wrap of the clock
_NOT_SENT = 0  # type: Final  # MESSAGE_INTERVAL of a message that there is not
_OFF = -1  # type: Final


class MessageRequests:
    """Uses the `telemetry`, which has the periodic messages."""

    def __init__(self, link: "Link", telemetry: "Telemetry") -> None:
        self._link = link
        self._telemetry = telemetry
        self._modes: list[int] = []  # those that are still to be told

    def result(self, number: float, second: float) -> int:
        """The MAV_RESULT of a request for message `number` (a float, as it came) with parameter `second`."""
        message = message_id(number)
        if message == MESSAGE_INTERVAL:
            return MAV_RESULT_DENIED if message_id(second) is None else MAV_RESULT_ACCEPTED
        if message == AVAILABLE_MODES:
            index = message_id(second)
            return MAV_RESULT_ACCEPTED if index is not None and index <= len(NAMES) else MAV_RESULT_DENIED
        if message in _OWN:
            return MAV_RESULT_ACCEPTED
        if message is None or not self._telemetry.sends(message):
            return MAV_RESULT_UNSUPPORTED
        return MAV_RESULT_ACCEPTED if self._telemetry.can_send(message) else MAV_RESULT_TEMPORARILY_REJECTED

    def send(self, number: float, second: float, now: int, uptime_us: int) -> None:
        """Send the message whose request had the result ACCEPTED."""
        message = int(number)
        if message in _ABOUT_MODES:
            self._telemetry.tell_mode()
        if message == MESSAGE_INTERVAL:
            self.send_interval(second)
        elif message == AUTOPILOT_VERSION:
            self._send_version()
        elif message == AVAILABLE_MODES:
            for mode in range(len(NAMES)):
                if second in (0.0, mode + 1.0) and mode not in self._modes:
                    self._modes.append(mode)
        elif message == AVAILABLE_MODES_MONITOR:
            self._link.answer(AVAILABLE_MODES_MONITOR, (0,))
        elif message == COMPONENT_METADATA:
            self._link.answer(COMPONENT_METADATA, (uptime_us // 1000, CRC32S[GENERAL], GENERAL_URI))
        else:
            _, _, length, _ = MESSAGES[message]
            self._link.budget.spend_on_answer(length + _AROUND)  # at most
            self._telemetry.send(message, now, uptime_us)

    def is_busy(self) -> bool:
        """True while there are modes to tell of."""
        return bool(self._modes)

    def send_some(self) -> None:
        """Tell of the modes that were asked for, while the link has room for answers."""
        while self._modes and self._link.budget.claim_answer_room():
            self._send_mode(self._modes.pop(0))

    def set_interval(self, number: float, interval_us: float) -> int:
        """Send message `number` each `interval_us`; 0 is as usual, -1 not at all. Return the MAV_RESULT."""
        message = message_id(number)
        if message is None or not self._telemetry.sends(message):
            return MAV_RESULT_UNSUPPORTED
        if interval_us not in (0.0, -1.0) and not _SHORTEST_US <= interval_us <= _LONGEST_US:
            return MAV_RESULT_DENIED
        return MAV_RESULT_ACCEPTED if self._telemetry.set_interval(message, int(interval_us)) else MAV_RESULT_DENIED

    def send_interval(self, number: float) -> None:
        """Tell how often message `number` is sent."""
        message = message_id(number)
        interval = _NOT_SENT
        if message is not None and self._telemetry.sends(message):
            interval = self._telemetry.interval(message) or _OFF
        self._link.answer(MESSAGE_INTERVAL, (interval, (message or 0) & 0xFFFF))

    def _send_mode(self, mode: int) -> None:
        name = NAMES[mode].encode()
        self._link.answer(AVAILABLE_MODES, (mode, _PROPERTIES.get(mode, 0), len(NAMES), mode + 1, 0, name))

    def _send_version(self) -> None:
        contract = tuple(int(CONTRACT_HASH[2 * index : 2 * index + 2], 16) for index in range(8))
        version = 0
        for number in FIRMWARE_VERSION:
            version = version << 8 | number
        version <<= 8
        none = (0,) * 8
        self._link.answer(
            AUTOPILOT_VERSION, (_CAPABILITIES, 0, version, 0, 0, 0, 0, 0) + none + contract + none + (0,) * 18
        )


def message_id(number: float) -> int | None:
    """A message id that came as a float, or None where it cannot be one."""
    return int(number) if 0.0 <= number <= _LAST_ID and number % 1.0 == 0.0 else None
