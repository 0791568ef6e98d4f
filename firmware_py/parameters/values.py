"""The parameters' present values, and the rules for accepting new ones."""

from ..generated_enums import (
    MAV_PARAM_ERROR_DOES_NOT_EXIST,
    MAV_PARAM_ERROR_PERMISSION_DENIED,
    MAV_PARAM_ERROR_READ_ONLY,
    MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
)
from .generated_parameters import (
    COUNT,
    DEFAULTS,
    DISARMED_ONLY,
    FLAGS,
    GREATESTS,
    LEASTS,
    NAMES,
    OFF_AT_ZERO,
    READ_ONLY,
    STEPS,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

UNKNOWN = -1  # type: Final


class Parameters:
    """`values` by index. `version` counts the changes, so that users of a copy notice them."""

    def __init__(self) -> None:
        self.values: list[float] = list(DEFAULTS)
        self.version: int = 0

    def index_of(self, name: bytes) -> int:
        """Index of the parameter of this `name` (bytes, padded with zeros or not), or UNKNOWN."""
        end = name.find(b"\0")
        if end >= 0:
            name = name[:end]
        return NAMES.index(name) if name in NAMES else UNKNOWN

    def refusal(self, index: int, value: float, armed: bool) -> int:
        """The MAV_PARAM_ERROR for which `value` cannot be set, or 0."""
        if not 0 <= index < COUNT:
            return MAV_PARAM_ERROR_DOES_NOT_EXIST
        least = LEASTS[index]
        step = STEPS[index]
        flags = FLAGS[index]
        if flags & READ_ONLY:
            return MAV_PARAM_ERROR_READ_ONLY
        if flags & OFF_AT_ZERO and value == 0.0:
            step = 0.0
        elif not least <= value <= GREATESTS[index]:  # also refuses NaN
            return MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE
        if step and (value - least) % step:
            return MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE
        if flags & DISARMED_ONLY and armed:
            return MAV_PARAM_ERROR_PERMISSION_DENIED
        return 0

    def set(self, index: int, value: float) -> None:
        """Set a value that was not refused; setting the same value is not a change."""
        if self.values[index] != value:
            self.version += 1
        self.values[index] = value  # (a zero has a sign)
