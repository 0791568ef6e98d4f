"""What every plant offers to the bridge, and the choice of one by its name."""

from typing import NamedTuple, Protocol

from sim_bridge.scenario import Scenario

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
    """A kite on its line. `step_s` is the longest step that it should be given."""

    step_s: float

    def step(self, dt: float, steering: float, gust: float) -> None:
        """Fly on by `dt` [s] with the mean actual `steering` and the wind's factor `gust`."""
        ...

    def truth(self) -> Truth:
        """The present state."""
        ...


def make_plant(scenario: Scenario, position: Vector, direction: Vector) -> Plant:
    """The plant that the scenario names, at a unit `position`, its nose in the unit tangent `direction`."""
    from sim_bridge.plant_turning_rate import TurningRatePlant  # noqa: PLC0415  one import a plant, when it is flown

    return {"turning-rate": TurningRatePlant}[scenario["plant.kind"]](scenario, position, direction)
