"""Jitter and loss of the radio link as additional dead time: the mean age of the data that the kite is steered by.

Both directions take the newest frame and hold it until a newer one comes. The effective delay is the time mean of
the age of the measurement behind the steering that acts, less the half period that belongs to sampling anyway, so that
tau' = tau + T/2 holds with it. The ages of the two directions are independent and add up.

For one direction, let A(a) be the probability that a frame arrives within `a` of being sent: without jitter, 0 before
the link's delay and 1 - loss from then on. With a frame each period T, the newest that is there at a random moment is
older than a + k T, 0 <= a < T, if those sent a, a + T, ... a + k T ago are all missing. Hence

    mean age = T/2 + sum over k of the integral over a from 0 to T of prod over i <= k of (1 - A(a + i T)),

and where the receiver looks once a period, as the firmware does at its samples, the same without T/2 and with T times
the value at a = 0 in the place of the integral. In closed form, each direction on its own adds to the delay:
    loss p, independent             T p / (1 - p)
    loss p, bursts of B frames      T p B     (Gilbert-Elliott; independent loss has B = 1 / (1 - p))
    jitter up to +-T/2, steering    nothing; with more of it newer frames overtake, and the age falls below the delay
    jitter up to +-T/2, samples     T/2, if the delay is a whole number of periods: half of the frames miss their tick

Validity. The loop sees the mean of exp(-s age), which is exp(-s mean) (1 + s^2 variance / 2): a varying age
acts as its mean with a little less gain. The limit of the mean age is therefore on the safe side, by about
1.2 (scatter / tau')^2 of itself near the paper's limit. Simulated limits were 0 to 3 % above it for a scatter up to
0.15 tau', and 11 % at 0.33 tau', with delays of 0.1 to 0.4 s, loss up to 60 % and jitter up to half the delay.
"""

import math
from typing import NamedTuple

import numpy as np

_POINTS = 400  # in a period, for the integral
_NEGLIGIBLE = 1e-9
_MOST_PERIODS = 100_000


class Path(NamedTuple):
    """One direction: delay [s], jitter [s] (uniform, plus or minus, never below 0), loss, burst of losses [frames].

    Losses are independent where `loss_burst` is 1 or less.
    """

    delay_s: float = 0.0
    jitter_s: float = 0.0
    loss: float = 0.0
    loss_burst: float = 0.0


class EffectiveDelay(NamedTuple):
    """Effective delay of a loop, the shares of samples and steering in it, and the age's standard deviation; all in s.

    The standard deviation excludes the sawtooth from holding a command for a period, which every loop has.
    """

    delay_s: float
    samples_s: float
    steering_s: float
    scatter_s: float


def effective_delay(samples: Path, steering: Path, loop_hz: float) -> EffectiveDelay:
    """Effective delay of a loop at `loop_hz` [Hz] that measures at its ticks, over the paths of samples and steering.

    The delay of the actuator belongs to the steering's path.

    Raises:
        ValueError: a time is negative, a loss is not at least 0 and below 1, or the rate is not positive.
    """
    if not 0.0 < loop_hz < math.inf:
        raise ValueError(f"loop rate of {loop_hz:g} Hz: must be positive and finite")
    period_s = 1.0 / loop_hz
    down_s, down_variance = _age(samples, period_s, np.zeros(1))
    middles = (np.arange(_POINTS) + 0.5) * period_s / _POINTS
    up_s, up_variance = _age(steering, period_s, middles)
    up_s -= 0.5 * period_s
    variance = down_variance + up_variance - period_s**2 / 12.0
    return EffectiveDelay(down_s + up_s, down_s, up_s, math.sqrt(max(0.0, variance)))


def _age(path: Path, period_s: float, after_s: np.ndarray) -> tuple[float, float]:
    """Mean [s] and variance [s^2] of the newest frame's age, at the times `after_s` (n,) [s] after one was sent.

    Looks back frame by frame, and keeps how likely it is that none has come so far, apart for a last one that was lost
    on the way and one that is late: with bursts, the one before a lost frame is more likely lost too.
    """
    _check(path)
    if path.loss_burst > 1.0:
        stay = 1.0 - 1.0 / path.loss_burst
        enter = min(1.0, (1.0 - stay) * path.loss / (1.0 - path.loss))
        lost_share = enter / (enter + 1.0 - stay) if path.loss else 0.0
    else:
        stay = enter = lost_share = path.loss
    lost, late = np.full(len(after_s), lost_share), np.full(len(after_s), 1.0 - lost_share)
    mean_s, square = float(np.mean(after_s)), float(np.mean(after_s**2))
    for k in range(_MOST_PERIODS):
        late = late * (1.0 - _arrived(path, after_s + k * period_s))
        missing = lost + late
        mean_s += period_s * float(np.mean(missing))
        square += period_s * float(np.mean(missing * (2.0 * after_s + (2 * k + 1) * period_s)))
        if missing.max() < _NEGLIGIBLE:
            break
        lost, late = lost * stay + late * enter, lost * (1.0 - stay) + late * (1.0 - enter)
    return mean_s, square - mean_s**2


def _arrived(path: Path, age_s: np.ndarray) -> np.ndarray:
    """Chance that a frame that is not lost has come `age_s` [s] after it was sent."""
    if path.jitter_s == 0.0:
        return (age_s >= path.delay_s - 1e-9).astype(float)
    share = np.clip((age_s + 1e-9 - path.delay_s + path.jitter_s) / (2.0 * path.jitter_s), 0.0, 1.0)
    return np.where(age_s >= 0.0, share, 0.0)


def _check(path: Path) -> None:
    for name, value in (("delay", path.delay_s), ("jitter", path.jitter_s)):
        if not 0.0 <= value < math.inf:
            raise ValueError(f"{name} of {value:g} s: must be zero or longer, and finite")
    if not 0.0 <= path.loss < 1.0:
        raise ValueError(f"loss of {path.loss:g}: must be at least 0 and below 1")
    if not 0.0 <= path.loss_burst < math.inf:
        raise ValueError(f"loss burst of {path.loss_burst:g} frames: must be zero or more, and finite")
