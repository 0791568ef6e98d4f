"""What each mode steers by: sticks in MANUAL, zenith in PARK, eight in TRACK, else neutral (docs/modes.md)."""

from ..generated_enums import KITE_MODE_MANUAL, KITE_MODE_PARK, KITE_MODE_STANDBY

TYPE_CHECKING = False
if TYPE_CHECKING:
    from ..modes.mode_machine import ModeMachine
    from .gains import Gains
    from .interface import Kite, OuterLoop
    from .steering import Steering


def steer_by_mode(
    modes: "ModeMachine", guidance: "OuterLoop", steering: "Steering", kite: "Kite", gains: "Gains", dt: float
) -> float:
    """Let `steering` ask for what the mode says, for the next `dt` [s]; return the target turning angle [rad].

    `kite` is an estimate, or the prediction. Where there is no target, the kite's own course is returned.
    """
    mode = modes.mode
    if mode == KITE_MODE_MANUAL:
        steering.hold(modes.manual_steering, dt)
        return kite.course
    if modes.stale or mode == KITE_MODE_STANDBY:
        steering.release()
        return kite.course
    if mode == KITE_MODE_PARK:
        steering.follow(0.0, 0.0, kite, gains, dt)  # straight up, towards the zenith
        return 0.0
    steering.follow(guidance.target_course, guidance.target_rate, kite, gains, dt)
    return guidance.target_course
