"""Angles in radians, in (-pi, pi] wherever they are wrapped."""

from math import pi, tau
from typing import Any


def wrap(angle: Any) -> Any:
    """An angle [rad], or an array of them, brought into (-pi, pi]."""
    wrapped = (angle + pi) % tau - pi
    return wrapped + tau * (wrapped <= -pi)
