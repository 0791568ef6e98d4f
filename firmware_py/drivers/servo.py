"""A steering servo on a PWM output."""

PERIOD_US = 20000  # 50 pulses a second


class Servo:
    """Converts steering to pulse widths, never beyond the end points.

    `pwm` has `duty_ns(ns)`, or else `duty_u16(share)` at a period of PERIOD_US. `minus_us`, `neutral_us` and `plus_us`
    are the pulses for steering -1, 0 and 1; a servo that turns the wrong way has the first and the last exchanged.
    """

    def __init__(self, pwm, minus_us, neutral_us, plus_us):
        self._in_ns = hasattr(pwm, "duty_ns")
        self._duty = pwm.duty_ns if self._in_ns else pwm.duty_u16
        self._minus = minus_us - neutral_us
        self._neutral = neutral_us
        self._plus = plus_us - neutral_us
        self._pulse = None
        self.write(0.0, False)

    def write(self, steering, armed):
        """Go to `steering`; to neutral if not `armed`, or if it is NaN."""
        offset = 0
        if armed:
            if steering >= 1.0:
                offset = self._plus
            elif steering <= -1.0:
                offset = self._minus
            elif steering > 0.0:
                offset = _round(steering * self._plus)
            elif steering < 0.0:
                offset = _round(-steering * self._minus)
        self._set(self._neutral + offset)

    def _set(self, pulse_us):
        if pulse_us == self._pulse:
            return
        self._pulse = pulse_us
        self._duty(pulse_us * 1000 if self._in_ns else pulse_us * 65535 // PERIOD_US)


def _round(value):
    return int(value + 0.5) if value >= 0.0 else -int(0.5 - value)
