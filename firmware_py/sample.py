"""What a sample from the sensors is, for the types alone: no board has this file."""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import TypeAlias

    # Values of KITE_SENSORS: time [us], azimuth, elevation [rad], distance [m], course, heading [rad], airspeed [m/s],
    # tether force [N], steering, and KITE_VALID bits of which of these are measured.
    Sample: TypeAlias = tuple[int, float, float, float, float, float, float, float, float, int]
