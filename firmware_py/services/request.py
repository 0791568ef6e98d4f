"""What a ground station asked for, as it waits in the queues: every field by its name."""

from ..generated_enums import (
    KITE_MODE_MANUAL,
    KITE_MODE_PARK,
    KITE_MODE_STANDBY,
    KITE_MODE_TRACK,
    MAV_CMD_COMPONENT_ARM_DISARM,
    MAV_CMD_DO_SET_MODE,
    MAV_CMD_PREFLIGHT_STORAGE,
    MAV_CMD_SET_MESSAGE_INTERVAL,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Final

_MODES = (KITE_MODE_STANDBY, KITE_MODE_MANUAL, KITE_MODE_PARK, KITE_MODE_TRACK)  # type: Final[tuple[int, ...]]
_CHANGING = (
    MAV_CMD_COMPONENT_ARM_DISARM, MAV_CMD_DO_SET_MODE, MAV_CMD_PREFLIGHT_STORAGE, MAV_CMD_SET_MESSAGE_INTERVAL,
)  # type: Final[tuple[int, ...]]


class Request:
    """A `message` with its `values` in wire order; `sender` is system and component of its station as one number.

    `sequence` is the number of its frame, None where nothing is known of the order.
    """

    def __init__(
        self, message: int, values: "tuple[Any, ...]", system: int, component: int, sequence: int | None = None
    ) -> None:
        self.message = message
        self.values = values
        self.system = system
        self.component = component
        self.sequence = sequence
        self.sender: int = system << 8 | component


class Command(Request):
    """A COMMAND_LONG or COMMAND_INT; the two lie alike up to the targets."""

    def __init__(
        self, message: int, values: "tuple[Any, ...]", system: int, component: int, sequence: int | None = None
    ) -> None:
        super().__init__(message, values, system, component, sequence)
        param1, param2, _, _, _, _, _, command, target_system, target_component = values[:10]
        self.command: int = command  # MAV_CMD
        self.target_system: int = target_system
        self.target_component: int = target_component
        self.param1: float = param1
        self.param2: float = param2
        self.overtaken: bool = False  # by one that came after it and was obeyed before it

    def changes(self) -> bool:
        """True for a command that changes something; the others only ask, and wait until an answer has room."""
        return self.command in _CHANGING

    def moves(self) -> bool:
        """True for a command that arms, disarms or asks for a mode that there is; another one is only answered."""
        if self.command == MAV_CMD_DO_SET_MODE:
            return self.param2 in _MODES
        return self.command == MAV_CMD_COMPONENT_ARM_DISARM and self.param1 in (0.0, 1.0)

    def wish(self) -> tuple[int, float]:
        """What a command that moves the kite asks for, to tell copies of it from others."""
        return self.command, self.param2 if self.command == MAV_CMD_DO_SET_MODE else self.param1

    def is_copy_of(self, other: "Command") -> bool:
        """True for the very frame again, over whatever link."""
        same = self.sender == other.sender and self.sequence == other.sequence is not None
        return same and self.wish() == other.wish()

    def disarms(self) -> bool:
        """True for a command that disarms, or asks for STANDBY."""
        return self.wish() in ((MAV_CMD_COMPONENT_ARM_DISARM, 0.0), (MAV_CMD_DO_SET_MODE, KITE_MODE_STANDBY))

    def is_urgent(self) -> bool:
        """True for a command that brings the kite to rest: disarm, or PARK."""
        return self.disarms() or self.wish() == (MAV_CMD_DO_SET_MODE, KITE_MODE_PARK)

    def is_safe(self) -> bool:
        """True for a command that an operator may need at any time: disarm, PARK, or MANUAL."""
        return self.is_urgent() or self.wish() == (MAV_CMD_DO_SET_MODE, KITE_MODE_MANUAL)


class ParameterSet(Request):
    """A PARAM_SET; `name` is bytes, padded with zeros or not."""

    def __init__(
        self, message: int, values: "tuple[Any, ...]", system: int, component: int, sequence: int | None = None
    ) -> None:
        super().__init__(message, values, system, component, sequence)
        value, target_system, target_component, name, _ = values
        self.value: float = value
        self.target_system: int = target_system
        self.target_component: int = target_component
        self.name: bytes = name
