"""The verdicts on a flight, and the rule by which it is judged."""

UNSTABLE_TURNING_ANGLE = 1.2  # [rad]
UNSTABLE_SATURATION = 0.3
ASTRAY = 0.5  # cross-track error over half the width of the eight: such a kite flies another curve
TRACKING, UNSTABLE, LOST, NOT_MEASURED = VERDICTS = ("tracking", "unstable", "lost", "not measured")
RULE = f"""\
A flight is judged from run.settle_s on, by the true position of the simulated kite, not by telemetry.
  lost          the kite crashed, or was not in TRACK for part of the measured time (disarmed, parked, steered
                by hand, or silent for 3 s); the numbers are those of the time in TRACK
  unstable      the turning-angle error is above {UNSTABLE_TURNING_ANGLE:g} rad RMS, the steering at its limit for more
                than {100 * UNSTABLE_SATURATION:.0f} % of the time, or the cross-track error above a quarter of the
                eight's width, RMS
  tracking      none of these
  not measured  the flight ended before run.settle_s
The mode is that of the autopilot's heartbeat, which it sends each second and at each change of mode."""
