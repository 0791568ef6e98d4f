"""The interface of all plants."""

from typing import NamedTuple, Protocol

from sim_bridge.wind.air import Air

Vector = tuple[float, float, float]


class Truth(NamedTuple):
    """The true state: unit position and velocity direction in the wind frame, angles [rad], SI units."""

    position: Vector
    velocity: Vector  # of the unit position [1/s]
    course: float
    heading: float
    distance: float
    airspeed: float
    tether_force: float


class Plant(Protocol):
    """A kite on its tether.

    `step_s` is the maximum step; `trouble` is the reason of a crash, None while it flies.
    """

    step_s: float
    trouble: str | None

    def step(self, dt: float, steering: float, air: Air) -> None:
        """Fly on by `dt` [s] with the mean actual `steering` in the wind `air`."""
        ...

    def truth(self) -> Truth:
        """The present state."""
        ...
