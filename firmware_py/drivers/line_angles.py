"""Line-angle sensors: azimuth and elevation of the line, measured at the ground by two AS5600 encoders.

They give only the position. Their resolution of 1.5 mrad is what a kite moves in a tick: the estimator takes
the course from positions COURSE_WINDOW apart.
"""

from math import pi

from ..clock import ticks_diff
from ..generated_enums import KITE_VALID_AZIMUTH, KITE_VALID_ELEVATION
from .as5600 import STEPS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

    from ..sample import Sample
    from .as5600 import As5600

_POSITION = KITE_VALID_AZIMUTH | KITE_VALID_ELEVATION  # type: Final
_HALF = STEPS // 2  # type: Final
_RADIANS = 2.0 * pi / STEPS  # type: Final
_LEAST_ELEVATION = -114  # type: Final  # [steps]: 10 deg below the horizon, where a kite on the ground hangs its line
_GREATEST_ELEVATION = STEPS // 4  # type: Final
_SLACK = 4  # type: Final  # [steps] that two readings may differ by, however short the time
_STEP_US = 300  # type: Final  # a line turns by no more than a step in this time: 293 deg/s
_FORGET_US = 500000  # type: Final  # after so long without a good reading the next one is believed wherever it is

NO_ANSWER = 0  # type: Final
NO_MAGNET = 1  # type: Final
OUT_OF_RANGE = 2  # type: Final
JUMP = 3  # type: Final


class Axis:
    """One angle of the line: an `encoder`, its raw reading at zero, and 1 or -1 for its direction."""

    def __init__(self, encoder: "As5600", zero: int, direction: int) -> None:
        self._encoder = encoder
        self._zero = zero
        self._direction = direction
        self.fault: int = NO_ANSWER

    def read(self) -> int | None:
        """The angle in steps, -2048 to 2047, or None with the reason in `fault`."""
        if not self._encoder.read():
            self.fault = NO_ANSWER
        elif not self._encoder.has_magnet():
            self.fault = NO_MAGNET
        else:
            return ((self._encoder.raw - self._zero) * self._direction + _HALF) % STEPS - _HALF
        return None


class LineAngles:
    """The board's sensors; `refused` counts the readings that gave no sample, by reason."""

    def __init__(self, azimuth: "Axis", elevation: "Axis") -> None:
        self._azimuth = azimuth
        self._elevation = elevation
        self._last: tuple[int, int, int] | None = None  # (time, azimuth, elevation) of the last good reading, in steps
        self.refused: list[int] = [0, 0, 0, 0]

    def sample(self, now: int) -> "Sample | None":
        """Values of KITE_SENSORS in wire order, or None if a reading is missing or impossible."""
        azimuth = self._read(self._azimuth)
        elevation = self._read(self._elevation)
        if azimuth is None or elevation is None:
            return None
        if not _LEAST_ELEVATION <= elevation <= _GREATEST_ELEVATION:
            self.refused[OUT_OF_RANGE] += 1
            return None
        if self._is_jump(azimuth, elevation, now):
            self.refused[JUMP] += 1
            return None
        self._last = (now, azimuth, elevation)
        return (now, azimuth * _RADIANS, elevation * _RADIANS, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, _POSITION)

    def _read(self, axis: "Axis") -> int | None:
        steps = axis.read()
        if steps is None:
            self.refused[axis.fault] += 1
        return steps

    def _is_jump(self, azimuth: int, elevation: int, now: int) -> bool:
        if self._last is None:
            return False
        then, last_azimuth, last_elevation = self._last
        passed = ticks_diff(now, then)
        if not 0 <= passed <= _FORGET_US:
            return False
        most = _SLACK + passed // _STEP_US
        around = (azimuth - last_azimuth + _HALF) % STEPS - _HALF
        return abs(around) > most or abs(elevation - last_elevation) > most
