"""The interface of all plants."""

from typing import Protocol

from sim_bridge.plants.truth import Truth
from sim_bridge.wind.air import Air


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
