"""A steering servo on a PWM output."""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Final

    from .interface import Pwm

PERIOD_US = 20000  # type: Final  # 50 pulses a second


class Servo:
    """Converts steering to pulse widths, never beyond the end points.

    `pwm` has `duty_ns(ns)`, or else `duty_u16(share)` at a period of PERIOD_US. `minus_us`, `neutral_us` and `plus_us`
    are the pulses for steering -1, 0 and 1; a servo that turns the wrong way has the first and the last exchanged.
    """

    def __init__(self, pwm: "Pwm", minus_us: int, neutral_us: int, plus_us: int) -> None:
        duty_ns = getattr(pwm, "duty_ns", None)
        self._in_ns: bool = duty_ns is not None
        self._duty: "Callable[[int], object]" = pwm.duty_u16 if duty_ns is None else duty_ns
        self._minus: int = minus_us - neutral_us
        self._neutral = neutral_us
        self._plus: int = plus_us - neutral_us
        self._pulse: int | None = None
        self.write(0.0, False)

    def write(self, steering: float, armed: bool) -> None:
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

    def _set(self, pulse_us: int) -> None:
        if pulse_us == self._pulse:
            return
        self._pulse = pulse_us
        self._duty(pulse_us * 1000 if self._in_ns else pulse_us * 65535 // PERIOD_US)


def _round(value: float) -> int:
    return int(value + 0.5) if value >= 0.0 else -int(0.5 - value)
