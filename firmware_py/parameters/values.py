"""The parameters' present values, and the rules by which a new one is taken or refused."""

from ..mavlink.generated_messages import (
    MAV_PARAM_ERROR_DOES_NOT_EXIST,
    MAV_PARAM_ERROR_PERMISSION_DENIED,
    MAV_PARAM_ERROR_READ_ONLY,
    MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
)
from .generated_parameters import DISARMED_ONLY, OFF_AT_ZERO, PARAMETERS, READ_ONLY

UNKNOWN = -1


class Parameters:
    """`values` by index. `version` counts the changes: who keeps a copy looks whether it moved."""

    def __init__(self):
        self.values = [entry[1] for entry in PARAMETERS]
        self.version = 0
        self._index = {entry[0].encode(): index for index, entry in enumerate(PARAMETERS)}

    def index_of(self, name):
        """Index of the parameter of this `name` (bytes, padded with zeros or not), or UNKNOWN."""
        end = name.find(b"\0")
        return self._index.get(name if end < 0 else name[:end], UNKNOWN)

    def name_of(self, index):
        """Name of a parameter, as bytes."""
        return PARAMETERS[index][0].encode()

    def refusal(self, index, value, armed):
        """The MAV_PARAM_ERROR for which `value` cannot be set, or 0."""
        if not 0 <= index < len(PARAMETERS):
            return MAV_PARAM_ERROR_DOES_NOT_EXIST
        _, _, least, greatest, step, flags = PARAMETERS[index]
        if flags & READ_ONLY:
            return MAV_PARAM_ERROR_READ_ONLY
        if flags & OFF_AT_ZERO and value == 0.0:
            step = 0.0
        elif not least <= value <= greatest:  # also refuses NaN
            return MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE
        if step and (value - least) % step:
            return MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE
        if flags & DISARMED_ONLY and armed:
            return MAV_PARAM_ERROR_PERMISSION_DENIED
        return 0

    def set(self, index, value):
        """Set a value that was not refused; the same one again is no change."""
        if self.values[index] != value:
            self.version += 1
        self.values[index] = value  # (a zero has a sign)
