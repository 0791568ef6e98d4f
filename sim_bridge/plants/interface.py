"""What every plant offers to the bridge."""

from typing import NamedTuple, Protocol

from sim_bridge.wind.air import Air

Vector = tuple[float, float, float]


class Truth(NamedTuple):
    """The kite as it is: unit position and velocity direction in the wind frame, angles [rad], SI units."""

    position: Vector
    velocity: Vector  # of the unit position [1/s]
    course: float
    heading: float
    distance: float
    airspeed: float
    tether_force: float


class Plant(Protocol):
    """A kite on its line.

    `step_s` is the longest step that it should be given; `trouble` says why it can fly no more, None while it can.
    """

    step_s: float
    trouble: str | None

    def step(self, dt: float, steering: float, air: Air) -> None:
        """Fly on by `dt` [s] with the mean actual `steering` in the wind `air`."""
        ...

    def truth(self) -> Truth:
        """The present state."""
        ...
